"""What may become of a mission that goes on is explored before anybody agrees to it."""

from __future__ import annotations

from math import inf, nan

import pytest

from checking.plans.conftest import ROOT
from pirate_sm.checking.resume_forecast import forecast
from pirate_sm.core._engine.resuming.reconciling import StateVerdict
from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import load_mission
from pirate_sm.core.program import Wait
from pirate_sm.core.resuming import (
    DarkWay,
    Resumption,
    VerdictTable,
    hypotheses,
    resumption,
    unknowns,
)
from pirate_sm.core.robot import at_rest_in

KNOWN = DarkWay(0.0, 0.0, True, "known")
UNKNOWN = DarkWay(-inf, inf, False, "unknown")


@pytest.fixture(scope="module")
def climb():
    return load_mission(ROOT / "sequences" / "climb.yaml")


def cut_off_in_a_wait(loaded, phase, states, way):
    """The mission is cut off in the wait of a phase, with the robot in these states."""
    robot, program = loaded.robot, loaded.program
    last, _ = Engine(robot, program, nominal=True).start(0.0)
    pc = next(
        at
        for at, it in enumerate(program.instructions)
        if isinstance(it, Wait) and it.phase == phase
    )
    last = last._replace(
        robot=at_rest_in(robot, robot.table.index_of(states)),
        mission=last.mission.at(pc)._replace(begun=True),
    )
    hypothesis = hypotheses(robot, program, last)[0]
    found = resumption(robot, program, last, 10.0, hypothesis, way)
    assert isinstance(found, Resumption)
    return found, hypothesis


DRIVING = ("DrivingBackward", "DrivingBackward", "DoubleClamped", "Unaligned", "Off")


def test_with_all_known_it_is_possible(climb):
    found, _ = cut_off_in_a_wait(climb, "down", DRIVING, KNOWN)

    assert forecast(climb, found) == ("possible", "", ())


def test_a_wait_for_a_position_that_nobody_knows_may_hang(climb):
    found, _ = cut_off_in_a_wait(climb, "down", DRIVING, UNKNOWN)

    expected = forecast(climb, found)

    assert expected.word == "may hang"
    assert "waits for a position" in expected.why
    assert "climb.yaml:39" in expected.why
    assert "DriveBackward" in expected.course[-1]


def test_a_position_that_is_read_is_among_the_unknowns(climb):
    found, _ = cut_off_in_a_wait(climb, "down", DRIVING, UNKNOWN)
    program = found.program(climb.program)

    told = found.unknown_position(climb.robot, program)

    assert told.startswith("the position: the mission reads it (")


def test_a_part_that_is_not_seen_to_hold_is_among_the_unknowns(climb):
    found, hypothesis = cut_off_in_a_wait(climb, "down", DRIVING, KNOWN)
    mark = next(each for each in sorted(hypothesis.body.marks) if each.kind == "part")
    verdict = StateVerdict(mark, "front", "holds", "unknown", "why", ())
    program = found.program(climb.program)

    told = unknowns(climb.robot, program, VerdictTable(hypothesis, (verdict,)))

    assert told == ("front holds: why",)


def test_what_cannot_succeed_fails_and_is_shown(bend):
    states = ("Fixed", "Fixed", "DoubleClamped", "Unaligned", "Off")
    last, _ = Engine(bend.robot, bend.program, nominal=True).start(0.0)
    last = last._replace(robot=at_rest_in(bend.robot, bend.robot.table.index_of(states)))
    chosen = hypotheses(bend.robot, bend.program, last)[0]
    found = resumption(bend.robot, bend.program, last, nan, chosen, KNOWN, "regrip")
    assert isinstance(found, Resumption)

    expected = forecast(bend, found)

    assert expected.word == "fails"
    assert "no path leads to an end that succeeds" in expected.why
    assert expected.course
