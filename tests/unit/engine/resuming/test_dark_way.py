"""How far a robot has driven while nobody recorded it, by what its wheels show."""

from __future__ import annotations

from dataclasses import replace
from math import nan, pi

import pytest
from cut_off import CutOff
from driving import BOTH_CLAMPED, IDLE, changed_newt, command

from pirate_sm.loading.robot import load_robot

RADIUS_M = 0.024
WHEELS = range(1, 7)
FORWARD = {number: 1 if number in (1, 3, 5) else -1 for number in WHEELS}
"""Which way each wheel turns when the robot goes forward."""


def rolled(way_m: float, **also: float) -> dict[str, float]:
    """What the wheel angles show after this way."""
    return {f"theta_{n}": FORWARD[n] * way_m / RADIUS_M for n in WHEELS} | also


def driving(drive, begun_m: float = 0.5, driven_s: float = 0.4) -> CutOff:
    """A robot that is cut off while it drives forward, half a metre on."""
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.signals |= rolled(begun_m)
    driver.run(1.0)
    command(driver, "DriveForward")
    driver.accept()
    driver.run(1.2)
    return CutOff(driver, driven_s)


def test_wheels_that_agree_show_the_way(drive):
    way = driving(drive).look(**rolled(0.52)).way

    assert way.exact
    assert way.low_m == way.high_m == pytest.approx(0.02, abs=1e-4)


def test_wheels_that_do_not_agree_leave_an_interval(drive):
    way = driving(drive).look(**rolled(0.52, theta_2=FORWARD[2] * 0.5 / RADIUS_M)).way

    assert not way.exact
    assert way.low_m == -way.high_m == pytest.approx(-0.4 * 4.17 * RADIUS_M)


def test_belief_in_an_exact_place_takes_more_than_one_wheel(drive):
    others = {f"theta_{number}": nan for number in WHEELS if number != 2}

    way = driving(drive).look(**rolled(0.52, **others)).way

    assert not way.exact
    assert way.low_m == -way.high_m < 0.0


def test_two_wheels_are_enough_for_an_exact_place(drive):
    others = {f"theta_{number}": nan for number in WHEELS if number not in (2, 5)}

    way = driving(drive).look(**rolled(0.52, **others)).way

    assert way.exact
    assert way.low_m == pytest.approx(0.02, abs=1e-4)


def test_counters_that_began_anew_show_nothing(drive):
    way = driving(drive).look(**rolled(0.0)).way

    assert not way.exact
    assert not way.moved


def test_counters_near_zero_may_have_begun_anew(drive):
    assert not driving(drive, begun_m=0.01).look(**rolled(0.02)).way.exact


def test_absolute_encoders_show_the_way_up_to_whole_turns(drive):
    cut = driving(drive, begun_m=0.01)
    dark = replace_absolute(cut)

    way = cut.look(**rolled(0.03 - 2 * pi * RADIUS_M)).way

    assert dark == frozenset(range(6))
    assert way.exact
    assert way.low_m == pytest.approx(0.02, abs=1e-4)


def test_absolute_encoders_do_not_tell_turns_apart(drive):
    cut = driving(drive, driven_s=1.0)
    replace_absolute(cut)

    assert not cut.look(**rolled(0.52)).way.exact


def replace_absolute(cut: CutOff) -> frozenset[int]:
    """All wheels of the robot have absolute encoders."""
    sight = cut.robot.sight
    dark = sight.dark._replace(absolute=frozenset(range(len(cut.robot.wheels))))
    cut.robot = replace(cut.robot, sight=replace(sight, dark=dark))
    return dark.absolute


def test_more_than_the_motors_can_do_is_asked_about(drive):
    found = driving(drive).look(**rolled(0.6))

    assert found.questions == (
        "wheels have rolled 100, 100, 100, 100, 100, 100 mm, but driven they can have 40 mm",
    )


def test_nobody_knows_the_way_of_wheels_driven_for_nobody_knows_how_long(drive):
    way = driving(drive, driven_s=float("inf")).look(**rolled(0.52)).way

    assert way.low_m == -way.high_m == float("-inf")


def test_a_robot_that_was_not_driven_is_where_it_was(drive):
    driver = drive(IDLE, states=BOTH_CLAMPED)
    driver.run(1.0)

    way = CutOff(driver, driven_s=5.0).look().way

    assert (way.low_m, way.high_m, way.exact) == (0.0, 0.0, True)


def test_the_profile_says_which_wheels_are_absolute(tmp_path):
    robot = changed_newt(tmp_path, ("name: left_fore,", "name: left_fore, absolute: true,"))

    assert load_robot(robot).normal.sight.dark.absolute == frozenset({0})
