"""A mission that changes its control, in the simulated pipe, nominally and out of its recording."""

from __future__ import annotations

import json
from itertools import groupby
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rolling_newt import BEARING, CONTROLS, rolling_newt

from pirate_sm import read, run
from pirate_sm.core import effects as fx
from pirate_sm.running.recording.csv_files import write_tables
from pirate_sm.running.recording.read.reader import Recording, read_recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay
from pirate_sm.running.recording.viewers.complete_recording import write_complete

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


IN_TURN = ["none", "gentle", "swift", "none"]


def in_turn(names):
    return [name for name, _ in groupby(names)]


def test_the_table_of_states_has_the_control_in_force(mission, recorded):
    states = read(mission.with_suffix(".mcap")).states

    assert list(states)[-2:] == ["unconfirmed", "control"]
    assert in_turn(states["control"]) == IN_TURN
    switched = states["control"].index("gentle")
    assert states["Grip"][switched] == states["Grip"][switched - 1] == "BothHeld"


def test_a_run_in_memory_has_it_too(mission):
    assert in_turn(run(str(mission), backend="trace").states["control"]) == IN_TURN


def test_it_is_a_column_of_the_csv_file(mission, recorded, tmp_path):
    with recorded_mission(recorded.header) as loaded:
        write_tables(recorded, loaded, tmp_path)

    header, *rows = (tmp_path / "states.csv").read_text(encoding="utf-8").splitlines()
    assert header.endswith(",unconfirmed,control")
    assert in_turn(row.rpartition(",")[2] for row in rows) == IN_TURN


def test_viewers_of_the_recording_are_told(mission, recorded, tmp_path):
    """With what is told every 0.1 s, so not of the switch at the very end of the run."""
    shown = tmp_path / "shown.mcap"
    with recorded_mission(recorded.header) as loaded:
        write_complete(recorded, loaded, shown)
    with shown.open("rb") as file:
        told = [
            json.loads(message.data)
            for _, channel, message in make_reader(file).iter_messages(topics=["/state"])
        ]

    assert in_turn(each["control"] for each in told) == IN_TURN[:3]


def test_the_report_has_a_lane_of_it(mission, recorded):
    page = read(mission.with_suffix(".mcap")).report().html

    assert '"control"' in page
    assert "swift" in page
