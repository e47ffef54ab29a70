"""Two legs meet where the joint angles show it."""

from __future__ import annotations

from math import asin, nan, pi, radians

import pytest

from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.mapping.axes import axis_at
from pirate_sm.lab.mapping.bend_angles import reached

FRONT, REAR = 0, 1
LEAN = asin((0.120 - 0.048) / 0.090)
OBLIQUE = asin((0.120 - 0.048) / 0.098)


def test_the_bend_that_is_seen_is_one_of_90_deg() -> None:
    """The rear lies along its leg, the front's first link leans to the wall of one at 90 deg."""
    robot = load_robot(library.find_robot("pirate_ii")).normal
    signals = {
        "gamma_3": -(LEAN + OBLIQUE),
        "gamma_4": 2 * LEAN,
        "gamma_2": radians(-50),
        "gamma_1": OBLIQUE + radians(50) - pi / 2 - LEAN,
        "phi": 0.0,
    }
    numbers = [nan] * len(robot.vocabulary.numbers)
    for name, value in signals.items():
        numbers[robot.vocabulary.numbers.index(name)] = value
    numbers[robot.body.parts[REAR].diameter] = 0.120
    axis = axis_at(robot.body, numbers, REAR)
    assert axis is not None
    seen = reached(robot.body, numbers, axis, FRONT, 1, 0.120)
    assert seen is not None
    assert seen.angle_rad == pytest.approx(pi / 2, abs=1e-6)
    assert seen.towards_rad == pytest.approx(0.0, abs=1e-6)
