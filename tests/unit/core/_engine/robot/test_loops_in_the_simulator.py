"""A mission whose tracks are kept at a speed, in the simulated pipe and out of its recording."""

from __future__ import annotations

from pathlib import Path

import pytest
from rolling_newt import rolling_newt

from pirate_sm import run
from pirate_sm.core.effects import Setpoints
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a patrol that has gone well."""
    folder = tmp_path_factory.mktemp("newt")
    file = folder / "patrol.mcap"
    done = run(str(rolling_newt(folder) / "patrol.yaml"), seed=1, record=file)
    assert done.outcome == "succeeded"
    return file


def test_the_stream_is_recorded_and_comes_out_the_same(recorded):
    recording = read_recording(recorded)
    sent = [each for step in recording.steps() for each in step.effects if type(each) is Setpoints]

    with recorded_mission(recording.header) as loaded:
        result = replay(recording, loaded)

    assert len(sent) > 50
    assert result.difference is None
