"""A run is killed at a random moment; its recording holds all but the last half second.

NIGHTLY=1 pytest tests/unit/running/recording/write/test_crashes.py     # a hundred moments
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest
from crashing import witnessed

from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay

HERE = Path(__file__).parent
MOMENTS = 100 if os.environ.get("NIGHTLY") else 3
PROMISED_S = 0.5
SPEEDS = (1.0, 8.0, float("inf"))


@pytest.mark.thorough
@pytest.mark.parametrize("moment", range(MOMENTS))
def test_all_but_the_last_half_second_is_kept(moment: int, tmp_path: Path) -> None:
    random = Random(moment)
    speed = SPEEDS[moment % len(SPEEDS)]
    recording, witness = tmp_path / "run.mcap", tmp_path / "witness"
    child = subprocess.Popen(
        [sys.executable, str(HERE / "crashing.py"), recording, witness, str(speed)],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(HERE.parents[4])},
    )
    assert child.stdout is not None
    child.stdout.readline()
    until_s = time.monotonic() + random.uniform(0.0, 0.1 if speed > 100 else 2.5)
    while (killed_s := time.monotonic()) < until_s:
        pass
    child.send_signal(signal.SIGKILL)
    child.communicate()

    found = read_recording(recording)
    steps = list(found.steps())
    due = [step for step, at_s in witnessed(witness) if at_s <= killed_s - PROMISED_S]

    assert len(steps) > max(due, default=-1)
    assert found.complete or len(found.notices) == 1
    with recorded_mission(found.header) as loaded:
        assert replay(found, loaded).difference is None
