"""What sensors say about a robot that was not watched for a while, by what they showed before.

Its controller was away, or nothing was recorded. How far it has driven meanwhile, what else has
changed, and what of that which was confirmed still counts.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import acos, degrees, hypot, inf, isnan, nan, pi, remainder
from typing import NamedTuple

from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import OF_WHEELS
from pirate_sm.core._engine.robot.evidence import kind_of, verdict
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    STOPPED,
    Mark,
    Marks,
    RobotState,
    at_rest_in,
    states_of,
)
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core.units import ACCELERATION

# --- what still counts ------------------------------------------------------------------------


def unproven(robot: RobotSpec, body: RobotState) -> Marks:
    """Return the marks of a robot of which nothing is confirmed any more.

    What had been confirmed is *declared*: sensors may confirm it. What was not confirmed keeps its
    mark, which only a command removes.
    """
    here = body.configuration
    kept = {mark for mark in body.marks if mark.command not in (DECLARED, STOPPED)}
    known = {(mark.kind, mark.which) for mark in kept}
    every = {Mark("part", part, DECLARED) for part in robot.held[here]}
    every |= {Mark("region", region, DECLARED) for region in range(len(robot.regions))}
    kept |= {mark for mark in every if (mark.kind, mark.which) not in known}
    return frozenset(kept | {Mark("region", each, STOPPED) for each in robot.driven[here]})


def denied(
    robot: RobotSpec, program: Program, last: EngineState, rest: RobotState
) -> Iterator[Mark]:
    """Yield the marks; those that the last known signals contradict are denied.

    A part that stands across the mouth of a tee, for example, shows another diameter. There the
    sensors say nothing now either, and a command must confirm the part. Wheels that turned may
    have come to rest since.
    """
    names, setpoints = states_of(robot, rest), at_rest_in(robot, rest.configuration).values
    for mark in rest.marks:
        numbers, diameter_m = last.sensing.numbers, program.diameter_m
        wheels = kind_of(robot, names, mark) in OF_WHEELS
        if mark.command != DECLARED or wheels:
            yield mark
        elif verdict(robot, setpoints, rest, mark, numbers, diameter_m).against:
            yield mark._replace(command=DENIED)
        else:
            yield mark


# --- what has changed -------------------------------------------------------------------------


def changed(robot: RobotSpec, was: Numbers, marks: Marks, numbers: Numbers) -> Iterator[str]:
    """Yield what a robot at rest does not change by itself: its attitude, its clamped joints.

    Args:
        robot: The robot.
        was: Signals as they were, SI.
        marks: The marks; the joints of a part that is declared to hold are compared.
        numbers: Signals now, SI.
    """
    dark = robot.sight.dark
    tilt = _tilt_rad(robot, was, numbers)
    if tilt > dark.tilt_rad:
        yield (
            f"the robot lies {degrees(tilt):z.0f} deg otherwise than before, "
            f"limit {degrees(dark.tilt_rad):z.0f} deg"
        )
    for part in sorted(m.which for m in marks if m.kind == "part" and m.command == DECLARED):
        spec = robot.sight.parts[part] if robot.sight.parts else None
        for joint in () if spec is None else spec.joints:
            angle = robot.slots[joint.slot].angle
            off = abs(numbers[angle] - was[angle])
            if off > dark.joint_rad:
                yield (
                    f"{robot.vocabulary.numbers[angle]} of the {robot.parts[part]} part shows "
                    f"{degrees(numbers[angle]):z.1f} deg, before {degrees(was[angle]):z.1f} deg, "
                    f"limit {degrees(dark.joint_rad):z.0f} deg off"
                )


def _tilt_rad(robot: RobotSpec, was: Numbers, now: Numbers) -> float:
    """Return the angle between the recorded direction of gravity and that of now; NaN unknown."""
    known = robot.vocabulary
    for board in robot.boards.values():
        for sources in board.vectors:
            if any(known.dimension(known.numbers[each]) != ACCELERATION for each in sources):
                continue
            before = [was[source] for source in sources]
            after = [now[source] for source in sources]
            size = hypot(*before) * hypot(*after)
            if size > 0:
                dot = sum(a * b for a, b in zip(before, after, strict=True)) / size
                return acos(max(-1.0, min(1.0, dot)))
    return nan


# --- how far it has driven --------------------------------------------------------------------


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
