"""Recomputes the traction of a recording for other motors.

The sign of a wheel's torque, and with it the normal forces, follow from the speed without load. A
profile that assumes it a fifth too small makes friction a fifth too small.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pirate_sm.core.events import SensorFrame
from pirate_sm.core.models import Motor
from pirate_sm.core.sensing import with_traction
from pirate_sm.lab.fitting.measurements import Columns
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import rerun
from pirate_sm.running.recording.tables import TIME


def signals_with(path: Path, motors: Mapping[str, Motor]) -> Columns | None:
    """Return the signals of a recording once in a round, with traction recomputed.

    What the mission did stays as it was recorded.

    Args:
        path: The recording.
        motors: The robot's motors by their kind.

    Returns:
        The signals, or None if the robot derives none of traction.

    Raises:
        RecordingError: The recording cannot be read.
    """
    recording = read_recording(path)
    rows: list[tuple[float, ...]] = []
    with recorded_mission(recording.header) as loaded:
        spec = loaded.robot.traction
        if spec is None:
            return None
        robot, origin_s = loaded.robot, recording.origin_s
        slots = enumerate(loaded.loaded_robot.profile.slots)
        known = {n: motors[slot.motor] for n, slot in slots if slot.motor in motors}
        motors_spec = spec.with_motors(
            {n: (motor.stall_torque, motor.no_load_speed) for n, motor in known.items()},
            loaded.loaded_robot.profile.simulation.tyre.rolling_resistance,
        )
        slipping, after_gaps = None, {gap.step for gap in recording.gaps}
        for each in rerun(recording, loaded):
            state, event = each.state, each.step.event
            if each.step.number in after_gaps:
                slipping = None  # what the wheels did in it is unknown
            if state is None or not isinstance(event, SensorFrame):
                continue
            if robot.boards[event.board].position != motors_spec.board:
                continue
            sensing, body = state.sensing, state.robot
            if slipping is not None:
                sensing = sensing._replace(traction=sensing.traction._replace(slipping=slipping))
            at, around, now_s = body.configuration, state.surveyed.reported, each.at_s + origin_s
            again = with_traction(robot, motors_spec, sensing, body.values, at, around, now_s)
            slipping = again.traction.slipping
            rows.append((each.at_s, *again.numbers[: len(robot.vocabulary.numbers)]))
    names = (TIME, *robot.vocabulary.numbers)
    values = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return dict(zip(names, values.T, strict=True))
