"""Bound how far a robot has driven while nobody recorded it."""

from __future__ import annotations

from math import inf, isnan, nan, pi, remainder
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.known_signals import Numbers, Sensing


class DarkWay(NamedTuple):
    """How far the robot has driven while nobody recorded it.

    Attributes:
        low_m: Least way, by the sign of odometry; ``high_m`` the largest.
        exact: Whether the wheels show the way; ``low_m`` and ``high_m`` are then equal.
        why: How that is known, for people.
    """

    low_m: float
    high_m: float
    exact: bool
    why: str


def dark_way(robot: RobotSpec, last: Sensing, numbers: Numbers, driven_s: float) -> DarkWay:
    """Return how far the robot has driven.

    The largest speed of the wheels bounds it. Absolute encoders show it up to whole turns: it is
    exact if the bound is below half a turn and all of them, at least two, agree.

    Args:
        robot: The robot.
        last: The signals as recorded last.
        numbers: The signals now.
        driven_s: How long the wheels may have been driven meanwhile; infinite if nobody knows.
    """
    dark = robot.sight.dark
    most_m = dark.top_m_s * driven_s if driven_s else 0.0
    ways = []
    for wheel in robot.wheels:
        was, now = last.angles[wheel.place], numbers[wheel.angle]
        if wheel.place not in dark.absolute or isnan(was) or isnan(now):
            continue
        if most_m >= pi * abs(wheel.metres_per_rad):
            why = "the robot may have driven half a turn of its wheels or more"
            return DarkWay(-most_m, most_m, False, why)
        ways.append(remainder(now - was, 2 * pi) * wheel.metres_per_rad)
    if len(ways) < 2:
        why = "its wheels have no absolute angles that are known before and after"
        return DarkWay(-most_m, most_m, most_m == 0, why if most_m else "no wheel was driven")
    if max(ways) - min(ways) > dark.agree_m:
        shown = ", ".join(f"{way * 1000:.0f}" for way in ways)
        why = f"its wheels do not agree, they have rolled {shown} mm"
        return DarkWay(-most_m, most_m, False, why)
    way_m = sum(ways) / len(ways)
    return DarkWay(way_m, way_m, True, f"{len(ways)} absolute wheel angles agree")


def unknown_way() -> DarkWay:
    """Return the way of a robot of which nothing is known."""
    return DarkWay(-inf, inf, False, "nobody knows for how long the wheels were driven")


def odometry_m(robot: RobotSpec, last: Sensing, way: DarkWay) -> float:
    """Return the odometry with the middle of the way added; NaN if the robot has no odometry."""
    if robot.odometry < 0:
        return nan
    known = last.numbers[robot.odometry]
    return known + (way.low_m + way.high_m) / 2 if way.high_m < inf else known
