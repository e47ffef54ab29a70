"""Which commands bring the robot to where a phase of a mission can begin."""

from __future__ import annotations

from dataclasses import replace

import pytest

from checking.plans.conftest import standing
from pirate_sm.checking.plans import beginnings, restoring, why_not_from
from pirate_sm.core.robot import STOPPED, Mark


@pytest.fixture(scope="module")
def begun_in(bend):
    return beginnings(bend)


def given(loaded, plan):
    return [loaded.robot.commands[step.command].name for step in plan.steps]


def test_a_phase_begins_where_the_mission_itself_enters_it(bend, begun_in):
    entered = {bend.robot.table.configurations[each] for each in begun_in["pass"]}

    assert entered == {("Free", "DrivingForward", "RearClampedFrontBending", "Unaligned", "On")}


def test_where_a_robot_was_adopted_changes_nothing_of_where_phases_begin(bend, begun_in):
    clamped = standing(bend, "Fixed", "Fixed", "DoubleClamped", "Unaligned", "Off").configuration
    adopted = replace(bend, program=replace(bend.program, start_configuration=clamped))

    assert beginnings(adopted) == begun_in


def test_a_robot_that_was_braked_by_hand_drives_again(bend, begun_in):
    body = standing(bend, "Fixed", "Fixed", "DoubleClamped", "Unaligned", "On")

    assert given(bend, restoring(bend, ["prepare"], body, begun_in)["prepare"]) == ["DriveForward"]


def test_a_state_that_a_stop_has_doubted_is_confirmed_again(bend, begun_in):
    body = standing(bend, "DrivingForward", "DrivingForward", "DoubleClamped", "Unaligned", "On")
    stopped = body._replace(
        marks=frozenset({Mark("region", 0, STOPPED), Mark("region", 1, STOPPED)})
    )

    assert why_not_from(bend, "prepare", stopped)
    plan = restoring(bend, ["prepare"], stopped, begun_in)["prepare"]
    assert given(bend, plan) == ["DriveForward"]
    assert why_not_from(bend, "prepare", plan.body) == ""


@pytest.mark.thorough
def test_each_phase_that_can_succeed_is_restored_from_both_clamps(bend, begun_in):
    body = standing(bend, "Fixed", "Fixed", "DoubleClamped", "Unaligned", "On")
    found = restoring(bend, bend.program.phases, body, begun_in)

    assert given(bend, found["pass"]) == ["RelaxFront", "BendInto", "DriveForward"]
    assert not any(found[phase].hindered for phase in ("pass", "prepare", "halt"))
    assert "regrip" not in found  # from there no path leads to a good end


def test_a_phase_that_begins_unclamped_is_not_restored_by_letting_go(bend, begun_in):
    body = standing(bend, "Fixed", "Fixed", "DoubleClamped", "Unaligned", "On")

    hindered = restoring(bend, ["enter"], body, begun_in)["enter"].hindered
    assert "lets go of front and rear" in hindered.hindrance
