"""A mission that changes its control, in the simulated pipe, on paper and out of its recording."""

from __future__ import annotations

from pathlib import Path

import pytest
from rolling_newt import BEARING, CONTROLS, rolling_newt

from pirate_sm import run
from pirate_sm.model import effects as fx
from pirate_sm.recording.read.reader import Recording, read_recording
from pirate_sm.recording.replay.recorded_mission import recorded_mission
from pirate_sm.recording.replay.replay import replay

MISSION = """\
format: 1
mission: gently
robot: newt
pipe: newt/elbow.yaml
starts_in: {Grip: Loose}
start: hold
phases:
  hold: {do: [HoldNose, HoldTail, {control: gentle}, GoAhead], go: drive}
  drive:
    wait: [{when: way >= 60 mm, go: swift}]
    within: {time: 20 s, go: failed}
  swift:
    do: [{control: swift}]
    wait: [{when: way >= 100 mm, go: usual}]
    within: {time: 20 s, go: failed}
  usual: {do: [Rest, {control: none}], go: done}
ends:
  done: {succeed: Done}
  failed: {fail: "Not done: {cause}"}
"""


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("gently")
    rolling_newt(folder, BEARING, CONTROLS)
    file = folder / "gently.yaml"
    file.write_text(MISSION, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def recorded(mission: Path) -> Recording:
    """The recording of a run that has gone well."""
    file = mission.with_suffix(".mcap")
    done = run(str(mission), seed=1, record=file)
    assert done.outcome == "succeeded", done.message
    return read_recording(file)


def test_it_comes_out_of_its_recording_the_same(recorded):
    with recorded_mission(recorded.header) as loaded:
        result = replay(recorded, loaded)

    assert result.difference is None


def test_it_tells_which_control_is_in_force(recorded):
    told = [each for step in recorded.steps() for each in step.effects if type(each) is fx.Log]

    assert [each.message for each in told if "control" in each.message] == [
        "control gentle", "control swift", "the usual control",
    ]  # fmt: skip


def test_a_trace_of_it_passes(mission):
    assert run(str(mission), backend="trace").outcome == "succeeded"
