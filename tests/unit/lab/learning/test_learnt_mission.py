from __future__ import annotations

from pathlib import Path

import pytest

import pirate_sm
from benchmarks.learnt_mission import mission_of

COURSE = (
    *("ClampFront", "ClampRear", "DriveForward", "wait close"),
    *("Brake", "RelaxFront", "BendInto", "DriveForward", "wait in"),
    *("Brake", "ClampFront", "RelaxRear", "BendBack", "ClampRear", "DriveForward", "wait"),
)
"""The course of the thesis, as an agent would take it."""


def test_a_course_becomes_a_mission_that_succeeds(tmp_path: Path) -> None:
    text = mission_of(COURSE, pirate_sm.load("mitre_bend"), "learnt")
    file = tmp_path / "learnt.yaml"
    file.write_text(text)

    assert [f for f in pirate_sm.check(file) if f.severity.word == "error"] == []
    run = pirate_sm.run(str(file), seed=1, start_jitter_m=0.01)
    assert (run.outcome, run.message) == ("succeeded", "The whole robot has passed")


def test_a_wait_in_which_nothing_was_heard_lasts_as_long() -> None:
    text = mission_of(("ClampFront", "wait 3.5 s"), pirate_sm.load("mitre_bend"), "learnt")
    more = mission_of(("ClampFront", "wait 3.5 s", "ClampRear"), pirate_sm.load("mitre_bend"), "x")

    assert "after" not in text  # the last wait is for the robot's arrival
    assert "wait: [{after: 3.5 s, go: part_2}]" in more
    assert more.endswith("within 60 s}\n")


def test_no_course_is_no_mission() -> None:
    with pytest.raises(pirate_sm.UsageError, match="needs a course"):
        mission_of((), pirate_sm.load("mitre_bend"), "learnt")
