"""A command that has a posture takes it first, and turns nothing before it has been seen."""

from __future__ import annotations

import math

import pytest
from driving import FRONT_CLAMPED, IDLE, REAR_CLAMPED, Driver, command

from pirate_sm.core._engine.robot.setpoint_arrays import pushed_harder
from pirate_sm.core._model import events as ev

APEX = math.radians(106)
QUARTER = math.pi / 2
REAR_HOLDS = {"gamma_1": -1.8, "gamma_2": 1.7, "gamma_3": -1.7, "gamma_4": APEX}
FRONT_HOLDS = {"gamma_1": -APEX, "gamma_2": 1.7, "gamma_3": -1.7, "gamma_4": 1.8}
LYING = {"gamma_1": 0.0, "gamma_2": 0.0, "gamma_3": -APEX / 2, "gamma_4": APEX}


def near(values: dict[str, float]) -> object:
    return pytest.approx(values)


def turned(values: dict[str, float], sign: int) -> dict[str, float]:
    return {name: sign * value for name, value in values.items()}


def held_by_the_rear(drive, mission: str = IDLE, *, sign: int = 1, **states: str) -> Driver:
    """The front has been clamped and relaxed, the rear holds; AlignRight has been accepted."""
    driver = drive(mission, states=REAR_CLAMPED | states)
    driver.signals |= turned(REAR_HOLDS | {"bend_torque_4": 0.7}, sign)
    driver.report_all(0.1)
    command(driver, "AlignRight")
    driver.accept()
    return driver


def show(driver: Driver, seconds: float = 0.5, **signals: float) -> None:
    """The sensors show this for a while, and every array is accepted."""
    driver.signals |= signals
    until = driver.now + seconds
    while driver.now < until:
        driver.run(driver.now + 0.1)
        if driver.in_flight:
            driver.accept()


@pytest.mark.parametrize(("polarity", "sign"), [("normal", 1), ("mirrored", -1)])
@pytest.mark.parametrize(
    ("states", "seen", "sent", "targets"),
    [
        (
            REAR_CLAMPED,
            REAR_HOLDS,
            {"bend_1": 0.5, "bend_2": -0.5, "bend_3": 0.5, "bend_4": 0.7},
            {"gamma_1": 0.0, "gamma_2": 0.0, "gamma_3": -APEX / 2},
        ),
        (
            FRONT_CLAMPED,
            FRONT_HOLDS,
            {"bend_1": -0.7, "bend_2": -0.5, "bend_3": 0.5, "bend_4": -0.5},
            {"gamma_2": APEX / 2, "gamma_3": 0.0, "gamma_4": 0.0},
        ),
    ],
)
def test_aligning_first_lays_the_module_along_the_wall_and_slackens_the_other_part(
    drive, states, seen, sent, targets, polarity, sign
):
    driver = drive(f"polarity: {polarity}\n{IDLE}", states=states)
    driver.signals |= turned(seen, sign)
    driver.report_all(0.1)

    command(driver, "AlignRight")

    names = driver.robot.vocabulary.numbers
    loops = {names[loop.angle]: loop.target_rad for loop in driver.state.robot.loops}
    assert driver.nonzero == near(turned(sent, sign))
    assert loops == pytest.approx(turned(targets, sign), abs=2e-3)


def test_it_turns_once_the_posture_is_seen_with_the_loops_at_zero(drive):
    driver = held_by_the_rear(drive)

    show(driver, **LYING)
    assert driver.nonzero == near({"bend_4": 0.7, "rotate": QUARTER})
    assert driver.last_status.status == "accepted"

    show(driver, phi=QUARTER)
    assert driver.last_status.status == "done"
    assert driver.last_status.reason == "the angle is at its setpoint"
    assert driver.unconfirmed == set()


@pytest.mark.parametrize(
    ("missing", "reason"),
    [
        (
            {"gamma_3": -APEX / 2 - math.radians(16)},
            "gamma_3 should be between -68 and -38 deg, shows -69 deg",
        ),
        ({"gamma_1": math.radians(16)}, "gamma_1 should be within 15 deg of zero, shows 16 deg"),
        ({"gamma_2": math.nan}, "gamma_2 should be within 15 deg of zero, has no value"),
        (
            {"bend_torque_4": 0.3},
            "bend_torque_4 should be at least 311 mNm in either direction, shows 300 mNm",
        ),
        (
            {"bend_torque_4": math.nan},
            "bend_torque_4 should be at least 311 mNm in either direction, has no value",
        ),
    ],
)
def test_it_does_not_turn_while_the_posture_is_not_seen(drive, missing, reason):
    mission = f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}"
    driver = held_by_the_rear(drive, mission)

    show(driver, 41.0, **LYING | missing)

    assert driver.array["rotate"] == 0.0
    assert driver.last_status.status == "failed"
    expected = f"not in the posture 'slack' within 40 s: {reason}"
    assert driver.last_status.reason.startswith(expected)
    assert driver.nonzero == near({"bend_4": 0.7})


def test_a_joint_that_stands_still_just_short_of_its_angle_counts(drive):
    driver = held_by_the_rear(drive)
    show(driver, **LYING | {"gamma_3": -APEX / 2 - math.radians(5)})
    assert driver.array["rotate"] == near(QUARTER)


OPENED = APEX + math.radians(10)
"""The apex after the other joint of its part has let it open further (in a round pipe)."""


@pytest.mark.parametrize(("harder", "duty"), [(False, 0.5), (True, 1.0)])
def test_a_joint_that_is_pushed_harder_is_so_while_its_angle_follows_the_apex(drive, harder, duty):
    driver = held_by_the_rear(drive)
    body = driver.state.robot
    (turning,) = (each for each in body.seekers if each.target_rad)
    if harder:
        loops = pushed_harder(body, (turning,))
        driver.state = driver.state._replace(robot=body._replace(loops=loops))

    show(driver, **LYING | {"gamma_4": OPENED, "gamma_3": REAR_HOLDS["gamma_3"]})

    (followed,) = (each for each in driver.state.robot.seekers if each.target_rad)
    assert followed.target_rad == pytest.approx(-OPENED / 2, abs=2e-3)
    assert driver.nonzero["bend_3"] == near(duty)


@pytest.mark.parametrize(("polarity", "sign"), [("normal", 1), ("mirrored", -1)])
def test_half_the_apexs_angle_follows_the_apex_while_it_opens(drive, polarity, sign):
    driver = held_by_the_rear(drive, f"polarity: {polarity}\n{IDLE}", sign=sign)

    opened = {"gamma_4": OPENED, "gamma_3": -OPENED / 2 - math.radians(2)}
    show(driver, **turned(LYING | opened, sign))

    assert driver.array["rotate"] == near(QUARTER)


def test_half_the_angle_that_the_apex_had_before_is_not_the_posture(drive):
    driver = held_by_the_rear(drive)

    show(driver, **LYING | {"gamma_4": OPENED, "gamma_3": -APEX / 2 + math.radians(11)})

    assert driver.array["rotate"] == 0.0
    assert driver.array["bend_3"] == pytest.approx(-0.5)
    show(driver, 41.0)
    expected = "not in the posture 'slack' within 40 s: gamma_3 should be"
    assert driver.last_status.reason.startswith(expected)


@pytest.mark.parametrize("apex", [APEX + math.radians(5), math.nan])
def test_an_apex_that_hardly_moves_or_is_not_known_leaves_the_angle_as_it_was(drive, apex):
    mission = f"on_fault: [{{fault: sensor.silent, then: continue}}]\n{IDLE}"
    driver = held_by_the_rear(drive, mission)
    before = driver.state.robot.loops

    show(driver, **LYING | {"gamma_2": math.radians(20), "gamma_4": apex})

    assert driver.state.robot.loops == before


def test_an_unknown_angle_fails_the_command_before_anything_moves(drive):
    driver = drive(IDLE, states=REAR_CLAMPED)
    driver.show(0.1, gamma_1=-1.8, gamma_2=1.7, gamma_3=-1.7)
    command(driver, "AlignRight")
    held = {"bend_3": -0.7, "bend_4": 0.7}
    assert driver.nonzero == near(held)
    driver.accept()

    assert driver.last_status.status == "failed"
    assert driver.last_status.reason == "gamma_4 is unknown, which the angle for bend_3 needs"
    assert driver.nonzero == near(held)


def test_a_posture_that_was_not_seen_leaves_the_clamp_unconfirmed(drive):
    driver = held_by_the_rear(drive)
    show(driver, 41.0, bend_torque_4=0.0)

    command(driver, "DriveForward")
    assert driver.last_status.reason == (
        "impossible: no clamp is confirmed to drive with; rear: its clamp is denied"
    )
    command(driver, "ClampFront")
    assert driver.statuses[-1] == ("ClampFront", "sent")


def test_a_posture_passed_over_by_the_operator_leaves_the_clamp_unconfirmed(drive):
    driver = drive(
        "start: a\nphases: {a: {do: [AlignRight], go: e}}\nends: {e: {succeed: ok}}\n",
        states=REAR_CLAMPED,
    )
    driver.signals |= REAR_HOLDS
    driver.report_all(0.1)
    driver.accept()
    driver.give(ev.Skip())
    assert driver.unconfirmed >= {"BendingState", "RotationState"}


def test_clamping_after_it_puts_the_whole_clamp_in_force(drive):
    driver = held_by_the_rear(drive)
    show(driver, **LYING)
    show(driver, phi=QUARTER)

    command(driver, "ClampFront")

    clamps = {"bend_1": -0.7, "bend_2": 0.7, "bend_3": -0.7, "bend_4": 0.7}
    assert driver.nonzero == near(clamps | {"rotate": QUARTER})


def test_aligning_back_takes_the_posture_again_which_is_there(drive):
    driver = held_by_the_rear(drive)
    show(driver, **LYING)
    show(driver, phi=QUARTER)

    command(driver, "AlignStraight")
    show(driver)
    assert driver.nonzero == near({"bend_4": 0.7})
    show(driver, phi=0.0)
    assert driver.statuses[-1] == ("AlignStraight", "done")


def test_the_safe_state_in_the_middle_of_it_keeps_the_apex_pressed(drive):
    driver = held_by_the_rear(drive)
    driver.give(ev.Abort("enough"))
    assert driver.nonzero == near({"bend_4": 0.7})


def test_a_pause_in_the_middle_of_it_goes_on_to_the_same_angles(drive):
    driver = held_by_the_rear(drive)
    driver.give(ev.Pause())
    assert driver.nonzero == near({"bend_4": 0.7})
    driver.accept()
    show(driver, 1.0)

    driver.give(ev.Resume())
    assert driver.nonzero == near({"bend_1": 0.5, "bend_2": -0.5, "bend_3": 0.5, "bend_4": 0.7})
    driver.accept()
    show(driver, **LYING)
    assert driver.array["rotate"] == near(QUARTER)


def test_driving_wheels_go_on_turning(drive):
    driver = held_by_the_rear(drive, RearWheelsState="DrivingForward")
    wheels = {name: driver.array[name] for name in ("wheel_4", "wheel_5", "wheel_6")}
    assert driver.array["bend_3"] == 0.5
    show(driver, **LYING)
    assert {name: driver.array[name] for name in wheels} == wheels


def test_an_unclamped_robot_turns_without_a_posture(drive):
    driver = drive(IDLE)
    driver.report_all(0.1)
    command(driver, "AlignRight")
    assert driver.nonzero == near({"rotate": QUARTER})


@pytest.mark.parametrize(
    ("states", "bending"),
    [
        (REAR_CLAMPED, "RearClampedFrontBending"),
        (FRONT_CLAMPED | {"RearWheelsState": "Fixed"}, "FrontClampedRearBendingBack"),
    ],
)
def test_a_bent_part_is_not_turned(drive, states, bending):
    driver = drive(IDLE, states=states | {"BendingState": bending})
    command(driver, "AlignRight")
    assert driver.last_status.reason.startswith("impossible: a bent part does not turn")
