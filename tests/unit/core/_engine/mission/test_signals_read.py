"""Which signals a mission and its robot decide by: conditions, fault rules, criteria, grips."""

from __future__ import annotations

from dataclasses import replace

import pytest
from driving import IDLE, PIRATE

from pirate_sm.core._engine.mission.program import DRIVEN, signals_read, slip_watched
from pirate_sm.core._engine.robot.criteria import Bound, CriterionSpec, only
from pirate_sm.core._expressions import compile_condition

WAITS = "wait: [{operator: stop, go: stopped}]"


@pytest.fixture
def read(drive):
    def names(body: str = IDLE, change=lambda robot: robot) -> set[str]:
        driver = drive(body, PIRATE)
        numbers = driver.robot.vocabulary.numbers
        found = signals_read(change(driver.robot), driver.engine.program)
        return {numbers[index] for index in found}

    return names


def waiting(condition: str) -> str:
    return IDLE.replace(WAITS, f'wait: [{{when: "{condition}", go: stopped}}]')


def test_what_a_mission_waits_for_is_read(read):
    assert "mu_used_3" not in read()
    assert "mu_used_3" in read(waiting("mu_used_3 > 0.3"))


def test_a_text_that_names_the_distance_reads_it(read):
    assert "odometry" not in read()
    assert "odometry" in read(IDLE.replace(WAITS, f'do: [{{log: "{DRIVEN}"}}]\n    {WAITS}'))


def test_the_change_of_a_signal_is_read_as_the_signal(read):
    assert "normal_force_2" in read(waiting("change(normal_force_2) > 1 N"))


def test_a_branch_reads_its_condition(read):
    body = IDLE.replace(WAITS, 'do: [{command: Brake, if: "slip_speed_4 > 1 mm/s"}]\n    ' + WAITS)

    assert "slip_speed_4" in read(body)


def test_a_fault_rule_reads_its_condition(read):
    def ruled(robot):
        condition = compile_condition("mu_used_5 > 0.3", robot.vocabulary)
        return replace(robot, faults=(replace(robot.faults[0], when=condition),))

    assert "mu_used_5" in read(change=ruled)


def test_a_criterion_reads_its_signals(read):
    def judged(robot):
        index = robot.vocabulary.numbers.index("slip_speed_1")
        done = CriterionSpec("below", "", "", (only(Bound(index, "<", 0.01)),))
        command = replace(robot.commands[0], done=done)
        return replace(robot, commands=(command, *robot.commands[1:]))

    assert "slip_speed_1" in read(change=judged)


def test_a_grip_reads_its_estimates_where_the_mission_uses_its_control(read):
    switched = IDLE.replace(WAITS, "do: [{control: careful}]\n    " + WAITS)

    assert not {"slip_speed_1", "mu_6"} & read()
    assert {"slip_speed_1", "mu_6"} <= read(switched)


def test_a_grip_that_knows_the_friction_watches_slip_under_its_control_only(read, drive):
    switched = IDLE.replace(WAITS, "do: [{control: exp_3c}]\n    " + WAITS)
    robot = drive(IDLE, PIRATE).robot
    names = [control.name for control in robot.controls]
    slip = robot.vocabulary.numbers.index("slip_speed_1")

    assert "slip_speed_1" not in read(switched)
    assert {names[control] for control, signals in slip_watched(robot) if slip in signals} >= {
        "exp_3c",
        "gentle",
    }
    assert "exp_3a" not in {names[control] for control, _ in slip_watched(robot)}
