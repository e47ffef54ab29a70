"""What is known of the pipe around the robot, in words."""

from __future__ import annotations

from math import nan, radians

from pirate_sm.core.effects import Environment


def test_an_angle_that_rounds_to_zero_has_no_sign() -> None:
    known = Environment("Straight", radians(-0.2), radians(-3), nan)

    assert known.measures == "roll 0°, pitch -3°"
