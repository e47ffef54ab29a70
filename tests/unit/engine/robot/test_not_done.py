"""A command that is not done in time says which sensors do not show it, and what they show."""

from __future__ import annotations

import math

import pytest
from driving import BOTH_CLAMPED, FRONT_CLAMPED, IDLE, REAR_CLAMPED, Driver, command

from pirate_sm.engine.robot.criteria import StalledSpec

SILENCE = f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}"


def reason(driver: Driver, name: str, until_s: float, **turning: float) -> str:
    """Give the command, let its array be accepted and its time pass; return why it failed."""
    command(driver, name)
    driver.accept()
    driver.run(driver.now + until_s, **turning)
    assert driver.last_status.status == "failed"
    return driver.last_status.reason


def test_a_clamp_that_does_not_bear_its_torque(drive):
    driver = drive(IDLE)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.12}

    assert reason(driver, "ClampFront", 10.1) == (
        "not done within 10 s: bend_torque_2 is 120 mNm, not above 500 mNm"
    )


def test_joints_that_still_turn(drive):
    driver = drive(IDLE)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.6}

    found = reason(driver, "ClampFront", 10.1, gamma_2=0.2)
    assert found == "not done within 10 s: gamma_rate_2 is 0.20 rad/s, not below 0.07 rad/s"


def test_a_joint_that_is_not_at_its_angle(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.signals["bend_torque_1"] = 0.0
    driver.show(0.1, gamma_1=math.radians(-20), gamma_2=math.radians(-45))

    assert reason(driver, "BendInto", 10.1) == (
        "not done within 10 s: gamma_1 is -20.0 deg, not at -45.0 deg"
    )


def test_wheels_that_do_not_turn(drive):
    driver = drive(IDLE, states=FRONT_CLAMPED)
    lacks = reason(driver, "DriveForward", 10.1)

    assert lacks.startswith("not done within ")
    assert "is 0.00 rad/s, not above 0.50 rad/s" in lacks


def test_a_board_that_has_never_reported_leaves_its_joint_unknown(drive):
    driver = drive(SILENCE)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": math.nan}
    command(driver, "ClampFront")
    driver.accept()
    driver.run(driver.now + 10.1)

    assert driver.last_status.reason == ("not done within 10 s: bend_torque_2 is unknown")


def test_a_board_that_does_not_report_any_more_is_the_reason(drive):
    driver = drive(SILENCE)
    driver.report_all(0.1)
    command(driver, "ClampFront")
    driver.accept()
    silent = next(
        board.id
        for board in driver.robot.boards.values()
        if driver.robot.vocabulary.numbers.index("bend_torque_2") in board.number_set
    )
    while driver.last_status.status != "failed":
        driver.now += 0.1
        for board in driver.robot.boards:
            if board != silent:
                driver.report(board)

    assert "bend_torque_2 is unknown (its board does not report)" in driver.last_status.reason


def test_a_criterion_that_has_just_been_met_has_not_been_met_for_long_enough(drive):
    driver = drive(IDLE)
    command(driver, "ClampFront")
    driver.accept()
    driver.run(9.8)
    driver.signals |= {"bend_torque_1": -0.6, "bend_torque_2": 0.6}
    driver.run(10.1)

    assert isinstance(driver.robot.commands[0].done, StalledSpec)
    assert driver.last_status.reason == (
        "not done within 10 s: it is so now, but not yet for 0.2 s"
    )


@pytest.mark.parametrize("name", ["Brake", "ToggleLighting"])
def test_a_command_that_is_done_names_nothing(drive, name):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    command(driver, name)
    driver.obey(1.0)

    assert "not" not in driver.last_status.reason
