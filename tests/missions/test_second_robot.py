"""A robot of YAML alone: nothing in the package knows its names, numbers or counts."""

from __future__ import annotations

from pathlib import Path

import pytest

NEWT = Path(__file__).resolve().parents[1] / "robots" / "newt"
PACKAGE = Path(__file__).resolve().parents[2] / "pirate_sm"


@pytest.mark.parametrize("backend", ["trace", "sim"])
def test_it_runs_its_own_mission(run, backend):
    record = run(NEWT / "patrol.yaml", backend=backend)
    assert record.ended.end == "back"
    assert ("BothHeld", "Ahead", "Dark") in record.states
    assert record.states[-1] == ("BothHeld", "Resting", "Dark")


def test_it_stops_short_of_the_bend_and_comes_back(run):
    record = run(NEWT / "patrol.yaml", backend="sim")
    assert record.fired == ["look", "home", "halt"]
    assert record.prepared.truth().distance_m == pytest.approx(0.0, abs=0.04)


def test_its_wire_is_its_own(run):
    record = run(NEWT / "take_hold.yaml", backend="trace")
    assert record.last_setpoints == {
        "drive_a": 0.0, "lamp": 0.0, "fold_neck": -0.5, "drive_b": 0.0, "fold_hip": 0.5,
        "drive_c": 0.0, "drive_d": 0.0,
    }  # fmt: skip


def test_it_holds_on_when_it_is_stuck(run, tmp_path):
    pipe = tmp_path / "blocked.yaml"
    text = (NEWT / "elbow.yaml").read_text("utf-8")
    pipe.write_text(f"{text}\nblockages: [{{at: 450 mm, lasting: 1 h}}]\n", encoding="utf-8")
    record = run(NEWT / "patrol.yaml", backend="sim", pipe=str(pipe))
    assert record.ended.end == "gave_up"
    assert "robot.stuck" in record.ended.message
    assert record.states[-1][0] == "BothHeld"


def test_a_dead_wheel_does_not_stop_it(run):
    record = run(NEWT / "patrol.yaml", backend="sim", defects=("hind_wheel_dead",))
    assert record.ended.outcome in ("succeeded", "failed")
    assert record.states[-1][0] == "BothHeld"
