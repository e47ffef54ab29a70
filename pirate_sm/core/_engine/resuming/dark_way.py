"""Find out how far a robot has driven while nobody recorded it."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isnan, nan, pi, remainder
from typing import NamedTuple

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.state import EngineState


class DarkWay(NamedTuple):
    """How far the robot has driven while nobody recorded it.

    Attributes:
        low_m: Least way, by the sign of odometry; ``high_m`` the largest.
        exact: Whether the way is known; it is the same as both bounds then.
        why: How it is known, or why it is not, for people.
        moved: What the wheels show that the motors cannot have done; empty if nothing.
        seen: Number indexes of the wheel angles that count on from where they were.
    """

    low_m: float
    high_m: float
    exact: bool
    why: str
    moved: str = ""
    seen: frozenset[int] = frozenset()


def dark_way(robot: RobotSpec, last: EngineState, numbers: Numbers, driven_s: float) -> DarkWay:
    """Return how far the robot has driven.

    The largest speed of the wheels bounds the way. The wheels that were driven show it if at least
    two of them do and all of these agree. An absolute angle shows it up to whole turns, if the
    bound is below half a turn. A counted angle shows it unless its counter may have begun anew,
    which is so if it is as near to zero as the robot can have driven since.

    Args:
        robot: The robot.
        last: The engine's last recorded state.
        numbers: The signals now.
        driven_s: How long the wheels may have been driven meanwhile; infinite if nobody knows, 0 if
            none was.
    """
    dark = robot.sight.dark
    most_m = dark.top_m_s * driven_s if driven_s else 0.0
    ways = [way for way in _ways(robot, last, numbers, most_m) if way.driven or not driven_s]
    rolled_m = [way.rolled_m for way in ways]
    shown = "wheels have rolled " + ", ".join(f"{way * 1000:z.0f}" for way in rolled_m) + " mm"
    seen = frozenset(way.angle for way in ways)
    if not driven_s:
        if last.robot.motion is None and max(map(abs, rolled_m), default=0.0) > dark.agree_m:
            moved = f"no wheel was driven, but {shown}"
            return DarkWay(-inf, inf, False, moved, moved)
        return DarkWay(0.0, 0.0, True, "no wheel was driven", "", seen)
    level = [way.level_m for way in ways]
    if max(map(abs, level), default=0.0) > most_m + dark.agree_m:
        moved = f"{shown}, but driven they can have {most_m * 1000:.0f} mm"
        return DarkWay(-inf, inf, False, moved, moved)
    if len(ways) > 1 and max(level) - min(level) <= dark.agree_m:
        way_m = sum(rolled_m) / len(ways)
        return DarkWay(way_m, way_m, True, f"{len(ways)} driven wheels agree on it", "", seen)
    why = f"its {shown}" if len(ways) > 1 else "its wheels do not show it"
    return DarkWay(-most_m, most_m, False, why)


def odometry_m(robot: RobotSpec, last: Sensing, way: DarkWay) -> float:
    """Return the odometry with the middle of the way added; NaN if the robot has no odometry."""
    if robot.odometry < 0:
        return nan
    known = last.numbers[robot.odometry]
    return known + (way.low_m + way.high_m) / 2 if way.high_m < inf else known


class _Way(NamedTuple):
    """The way of one wheel.

    Attributes:
        angle: Number index of its angle.
        driven: Whether it was driven when the recording ends.
        rolled_m: Way since its board was recorded last.
        level_m: Way since the last of all boards was, for comparison.
    """

    angle: int
    driven: bool
    rolled_m: float
    level_m: float


def _ways(robot: RobotSpec, last: EngineState, numbers: Numbers, most_m: float) -> Iterator[_Way]:
    """Yield the way of each wheel that shows it."""
    dark, sensing = robot.sight.dark, last.sensing
    for wheel, board in zip(robot.wheels, robot.wheel_boards, strict=True):
        was, now = sensing.angles[wheel.place], numbers[wheel.angle]
        size_m = abs(wheel.metres_per_rad)
        if isnan(was) or isnan(now):
            continue
        if wheel.place in dark.absolute:
            if most_m >= pi * size_m:
                continue
            rolled_m = remainder(now - was, 2 * pi) * wheel.metres_per_rad
        elif abs(now) * size_m > most_m + dark.agree_m:
            rolled_m = (now - was) * wheel.metres_per_rad
        else:
            continue
        speed_m_s = sensing.numbers[wheel.speed] * wheel.metres_per_rad
        earlier_s = max(sensing.heard_s) - sensing.heard_s[board]
        level_m = rolled_m - (0.0 if isnan(speed_m_s) else speed_m_s * earlier_s)
        yield _Way(wheel.angle, last.robot.latest[wheel.slot] != 0, rolled_m, level_m)
