"""What values the signals of a robot can have."""

from __future__ import annotations

from math import pi, radians
from pathlib import Path

import pytest

from checking.robots import changed
from checking.small_missions import NEWT
from pirate_sm.checking.exploring.signal_ranges import ranges
from pirate_sm.core.expressions import change_of
from pirate_sm.core.loading import load_robot

PIRATE = NEWT.parents[2] / "hardware_profiles" / "pirate_ii"


def test_a_joint_stays_inside_its_end_stops() -> None:
    loaded = load_robot(NEWT)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found["neck"] == pytest.approx((-radians(130), radians(130)))


def test_what_the_wire_cannot_carry_cannot_be() -> None:
    loaded = load_robot(NEWT)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found["roll_a"].high == pytest.approx(2**15 * 2 * pi / 2000)


def test_what_the_engine_takes_for_implausible_is_unknown_and_no_value() -> None:
    loaded = load_robot(PIRATE)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found["bend_torque_1"] == pytest.approx((-8 * 1.01, 8 * 1.01))
    assert found["wheel_current_1"] == pytest.approx((-2 * 0.54, 2 * 0.54))
    assert found["wheel_torque_1"].high == pytest.approx(2 * 0.54 * 8.44e-3 * 112)


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


def test_a_torque_worked_out_from_a_current_is_limited_as_that_is() -> None:
    loaded = load_robot(PIRATE)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    most = 8.44e-3 * 112 * found["wheel_current_1"].high  # torque_of in the profile
    assert found["wheel_torque_1"] == pytest.approx((-most, most))
    assert 0 < found["wheel_torque_1"].high != found["wheel_current_1"].high


def test_a_torque_has_a_range_whatever_the_sign_of_its_scale(tmp_path: Path) -> None:
    robot = changed(
        PIRATE, tmp_path, "profile.yaml",
        ("wheel_torque_1: {torque_of: wheel_current_1, slot: wheel_1, scale: 8.44",
         "wheel_torque_1: {torque_of: wheel_current_1, slot: wheel_1, scale: -8.44"),
    )  # fmt: skip
    loaded = load_robot(robot)
    found = ranges(loaded.profile, loaded.oriented("normal"))["wheel_torque_1"]

    assert found.low < 0 < found.high


def test_a_signal_changes_by_the_width_of_its_range_at_most() -> None:
    loaded = load_robot(NEWT)
    found = ranges(loaded.profile, loaded.oriented("normal"))

    assert found[change_of("neck")] == pytest.approx((-radians(260), radians(260)))
