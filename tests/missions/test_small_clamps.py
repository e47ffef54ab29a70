"""A clamp that a control holds by little is not taken for a lost one, and a lost one is told."""

from __future__ import annotations

import shutil

import pytest

from pirate_sm.core import library
from pirate_sm.core.effects import Fault

SMALL = """\
  small:
    description: As exp_3a, clamped by 100 mNm
    extends: exp_3a
    actuation:
      BendingState:
        DoubleClamped: {bend_1: -100 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 100 mNm}
"""
MISSION = """\
format: 1
mission: small
robot: ROBOT
pipe: {description: Level, diameter: 120 mm, segments: [{straight: LENGTH}], start: {at: 800 mm}}
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
time_limit: 2 min
on_fault:
  - {fault: [clamp.slipping, clamp.lost, robot.stuck, wheel.dead], then: continue}
start: hold
phases:
  hold: {do: [{control: small}], wait: [{after: 2 s, go: drive}]}
  drive: {do: [DriveForward], wait: [{after: DRIVES, go: stop}]}
  stop: {do: [Brake], wait: [{after: 1 s, go: bend}]}
  bend: {do: [RelaxRear, BendInto], wait: [{after: 1 s, go: done}]}
ends: {done: {succeed: Done}}
"""


@pytest.fixture
def held_by_little(run, tmp_path):
    """Drives with 100 mNm at each apex through a pipe of this length, then bends the rear."""

    def go(length: str, drives: str, seed: int):
        robot = tmp_path / "pirate_ii"
        shutil.copytree(library.find_robot("pirate_ii"), robot)
        profile = robot / "profile.yaml"
        text = profile.read_text("utf-8")
        profile.write_text(text.replace("  exp_3b:\n", f"{SMALL}  exp_3b:\n", 1), "utf-8")
        words = {"ROBOT": str(robot), "LENGTH": length, "DRIVES": drives}
        mission = MISSION
        for word, value in words.items():
            mission = mission.replace(word, value)
        (tmp_path / "small.yaml").write_text(mission, "utf-8")
        return run(tmp_path / "small.yaml", backend="sim", seed=seed, check=False)

    return go


@pytest.mark.thorough
def test_it_is_reported_neither_as_lost_nor_as_slipping(held_by_little):
    record = held_by_little("2.4 m", "3 s", 2)

    assert record.ended.outcome == "succeeded", record.ended.message
    assert record.of(Fault) == []


def test_it_is_reported_as_lost_where_the_pipe_ends(held_by_little):
    record = held_by_little("1.1 m", "7 s", 1)

    assert record.ended.outcome != "succeeded"
    first = record.of(Fault)[0]
    assert (first.code, "the front" in first.message) == ("clamp.lost", True)
