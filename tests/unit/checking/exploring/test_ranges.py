"""What values the signals of a robot can have."""

from __future__ import annotations

from math import pi, radians

import pytest

from checking.small_missions import NEWT
from pirate_sm.checking.exploring.ranges import ranges
from pirate_sm.loading.robot import load_robot

PIRATE = NEWT.parents[2] / "hardware_profiles" / "pirate_ii"


def test_a_joint_stays_inside_its_end_stops() -> None:
    loaded = load_robot(NEWT)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found["neck"] == pytest.approx((-radians(130), radians(130)))


def test_what_the_wire_cannot_carry_cannot_be() -> None:
    loaded = load_robot(NEWT)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found["neck_torque"] == pytest.approx((-(2**15) * 0.5e-3, 2**15 * 0.5e-3))


def test_a_diameter_lies_between_two_wheels_and_the_links_stretched_out() -> None:
    loaded = load_robot(NEWT)
    low, high = ranges(loaded.profile, loaded.oriented("normal"))["width_nose"]

    assert low == pytest.approx(0.04)
    assert low < high < 0.3


def test_angles_of_the_accelerometer_are_angles() -> None:
    loaded = load_robot(PIRATE)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found["roll"] == (-pi, pi)
    assert found["pitch"] == (-pi / 2, pi / 2)
    assert found["acceleration"].low == 0


def test_what_adds_up_has_no_range() -> None:
    loaded = load_robot(NEWT)

    assert "way" not in ranges(loaded.profile, loaded.oriented("normal"))
