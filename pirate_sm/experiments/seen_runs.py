"""Runs that a camera watches, as the thesis's did: where it saw the robot along the pipe."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import numpy as np

from pirate_sm.api import Run, run
from pirate_sm.recording.read.reader import read_recording
from pirate_sm.simulation.arrays import Floats


def seen_run(
    mission: str, camera: str, defects: Sequence[str]
) -> tuple[Run, tuple[Floats, Floats]]:
    """Return a run with the camera as detector, and when and where it saw the robot.

    Args:
        mission: Name of the mission.
        camera: Name of a synthetic camera.
        defects: That the robot has.

    Returns:
        The run; times in s and the mean position of the wheels that were seen, m along the pipe.

    Raises:
        LoadError: The mission or the camera cannot be loaded.
        UsageError: An extra is not installed.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "seen.mcap"
        made = run(mission, defects=defects, detector=f"vision:{camera}", record=path)
        body = made.loaded.loaded_robot.profile.body
        names = [f"{wheel.name}_m" for wheel in body.wheels]
        seen: dict[float, float] = {}
        for shown in read_recording(path).shown("/vision"):
            places = [shown.content[name] for name in names if name in shown.content]
            if len(places) == len(names):
                seen[round(shown.at_s - shown.content["age_s"], 6)] = fmean(places)
    return made, (np.array(list(seen)), np.array(list(seen.values())))
