"""The pipe around the robot, derived from its own signals and the detector's words (thesis alg. 5).

- *Diameter*: that of the parts whose clamp is confirmed, h + 2r (eq. 3-2). In a bend a part counts
  only if it shows the diameter of the straight before: one that stands askew over the bend
  shows another, and its axis is not that of the pipe.
- *Pitch and roll*: the accelerometer's, turned into the axis of the pipe. A clamped part lies
  along the pipe; the link with the accelerometer stands obliquely to it, at the heading that the
  joint angles in between give.
- *Segment*: ``Joint`` from the first word of a bend until the one that says that the whole robot
  is beyond it, and wherever two clamped parts lie along different axes; ``Out`` where every
  clamped part has opened to its end stop, so that there is no wall; ``Straight`` where a part has
  a wall and no bend has been announced.

What cannot be known is NaN, or an empty segment. A report from outside counts instead for as long
as it is valid.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, inf, isnan, nan, pi, radians, remainder
from statistics import median
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import RobotState, confirmed_parts
from pirate_sm.engine.sensing.body_spec import BodySpec
from pirate_sm.geometry.plane import turned
from pirate_sm.geometry.space import GRAVITY_M_S2, Vector
from pirate_sm.model.effects import Environment

OUT, STRAIGHT, JOINT = SEGMENTS = ("Out", "Straight", "Joint")
"""What the segment may be called (thesis section 4-3-2)."""

SURVEY_EVERY_S = 0.2
"""Often enough at 0.1 m/s, and slow beside the cost of looking [decided]."""

_SAMPLES = 9
"""Of this many accelerations the median counts: a jolt of a motor is not gravity [decided]."""

_AT_REST = 0.1
"""An acceleration that differs from gravity by a larger share of it is not its direction."""

_UPRIGHT = 0.2
"""Where less than this share of gravity lies across the pipe (78 deg), it has no roll."""

_TURNED_RAD = radians(20)
"""Axes of two clamped parts that differ by more belong to two legs [decided]."""

_COPLANAR_RAD = radians(10)
"""With more roll between the parts their headings cannot be compared."""

_LEAST_SAMPLES = 5
"""With fewer of them roll and pitch are not known yet."""

_AGREEING = 0.03
"""Parts whose diameters differ by a larger share do not all stand in a straight [decided]."""

_OPEN_RAD = radians(2)
"""A clamped V this near to its end stop has no wall [decided]."""

_NOISE_RAD, _NOISE_M = radians(1), 1e-3
"""Changes up to these are not reported."""

_NO_FORCE: Vector = (nan, nan, nan)
NOTHING_AROUND = Environment("", nan, nan, nan)


class Surveyed(NamedTuple):
    """What is remembered of the surroundings.

    Attributes:
        reported: The last report, to compare the next one with.
        forces: The last specific forces along the pipe, to side B and up, m/s^2.
        felt_s: When the last of them was measured.
        part: The clamped part along which they were turned; -1 without one.
        in_bend: Whether a word has announced a bend that no word has said to be passed.
        due_s: When to look again.
        outside_until_s: Until when a report from outside is valid.
        straight_m: The diameter of the last straight; NaN before the first.
    """

    reported: Environment = NOTHING_AROUND
    forces: tuple[Vector, ...] = ()
    felt_s: float = -inf
    part: int = -1
    in_bend: bool = False
    due_s: float = -inf
    outside_until_s: float = -inf
    straight_m: float = nan


def nothing_surveyed(*, nominal: bool) -> Surveyed:
    """Return what is known at first; where no sensor will speak there is nothing to look for."""
    return Surveyed(due_s=inf) if nominal else Surveyed()


def survey(
    robot: RobotSpec,
    before: Surveyed,
    state: RobotState,
    numbers: Sequence[float],
    word: str | None,
    raised: frozenset[int],
    now_s: float,
) -> tuple[Surveyed, Environment]:
    """Return what is to be remembered, and the surroundings as signals and words tell them.

    Args:
        robot: The robot.
        before: What was remembered.
        state: What the robot is commanded to.
        numbers: Every signal in SI; NaN is unknown.
        word: The detector's valid word, if there is one.
        raised: Fault rules that are raised, by index.
        now_s: When it is.
    """
    body = robot.body
    in_bend = before.in_bend if word is None else word not in robot.words_behind
    opened = robot.held[state.configuration] & robot.denied_by(raised).keys()
    held = sorted(confirmed_parts(robot, state) | opened)
    walled = [part for part in held if not _is_open(body, part, numbers)]
    segment = ""
    if word is not None and in_bend:
        segment = JOINT
    elif held and not walled:
        segment = OUT
    elif walled:
        segment = _segment(body, walled, numbers, in_bend)
    along = _along(body, walled, numbers, before.straight_m)
    if segment == STRAIGHT:
        along = along or walled
    else:
        walled = along
    part = before.part if before.part in along else along[0] if along else -1
    forces, felt_s = _felt(robot, before, part, numbers, now_s)
    diameter_m = _diameter(body, walled, numbers)
    known = segment == STRAIGHT and not isnan(diameter_m)
    straight_m = diameter_m if known else before.straight_m
    due_s, outside_until_s = now_s + SURVEY_EVERY_S, before.outside_until_s
    felt = before.reported, forces, felt_s, part, in_bend
    after = Surveyed(*felt, due_s, outside_until_s, straight_m)
    return after, Environment(segment, *_attitude(forces), diameter_m)


def _along(
    body: BodySpec, parts: list[int], numbers: Sequence[float], straight_m: float
) -> list[int]:
    """Return the parts that lie along the pipe: they show the diameter of the last straight.

    Where that is unknown two parts can be compared with each other only, and one alone shows
    nothing.
    """
    if isnan(straight_m):
        return parts if len(parts) > 1 else []
    shown = [(part, body.parts[part].diameter) for part in parts]
    return [
        part
        for part, diameter in shown
        if diameter >= 0 and abs(numbers[diameter] - straight_m) <= _AGREEING * straight_m
    ]


def _segment(body: BodySpec, walled: Sequence[int], numbers: Sequence[float], in_bend: bool) -> str:
    """Return the segment of a robot that holds on and of which no bend's word is valid."""
    if len(walled) > 1 and _turn(body, walled, numbers) > _TURNED_RAD:
        return JOINT
    return "" if in_bend else STRAIGHT


def _turn(body: BodySpec, parts: Sequence[int], numbers: Sequence[float]) -> float:
    """Return the largest angle between the axes along which parts lie; 0 where it is unknown."""
    roll = body.imu.roll if body.imu else -1
    if roll >= 0 and not abs(numbers[roll]) <= _COPLANAR_RAD:
        return 0.0
    headings = [body.heading_in_pipe(numbers, part, 0) for part in parts]
    known = [heading for heading in headings if not isnan(heading)]
    return max(known, default=0.0) - min(known, default=0.0)


def _is_open(body: BodySpec, part: int, numbers: Sequence[float]) -> bool:
    vee = body.parts[part]
    return vee.angle >= 0 and abs(numbers[vee.angle]) > vee.end_stop_rad - _OPEN_RAD


def _diameter(body: BodySpec, parts: Sequence[int], numbers: Sequence[float]) -> float:
    """Return the mean inner diameter that the parts show, m; NaN where none does, or they differ.

    A part that stands over a bend shows another diameter than that of the pipe.
    """
    shown = [numbers[body.parts[part].diameter] for part in parts if body.parts[part].diameter >= 0]
    known = [diameter for diameter in shown if not isnan(diameter)]
    if not known or max(known) - min(known) > _AGREEING * max(known):
        return nan
    return sum(known) / len(known)


def _felt(
    robot: RobotSpec, before: Surveyed, part: int, numbers: Sequence[float], now_s: float
) -> tuple[tuple[Vector, ...], float]:
    """Return the last specific forces in the axes of the pipe, and when the last was measured."""
    forces = before.forces if part == before.part else ()
    force = _in_pipe(robot.body, part, numbers) if part >= 0 else _NO_FORCE
    if abs(hypot(*force) - GRAVITY_M_S2) <= _AT_REST * GRAVITY_M_S2:
        return (*forces, force)[-_SAMPLES:], now_s
    lasting = now_s - before.felt_s < robot.link.stale_after_s
    return (forces if lasting else ()), before.felt_s


def _in_pipe(body: BodySpec, part: int, numbers: Sequence[float]) -> Vector:
    """Return the specific force along the axis in which a part is clamped, to its B and up."""
    imu = body.imu
    if imu is None:
        return _NO_FORCE
    ahead, side_b, up = (numbers[axis] for axis in imu.axes)
    if imu.roll >= 0 and body.parts[part].wheels[0] > imu.link:
        # The part is behind the roll joint, the accelerometer ahead of it.
        side_b, up = turned((side_b, up), -numbers[imu.roll])
    return *turned((ahead, side_b), -body.heading_in_pipe(numbers, part, imu.link)), up


def _attitude(forces: Sequence[Vector]) -> tuple[float, float]:
    """Return roll and pitch (B-13 and B-14), rad; NaN where they are unknown."""
    if len(forces) < _LEAST_SAMPLES:
        return nan, nan
    along, side_b, up = (median(values) for values in zip(*forces, strict=True))
    across = hypot(side_b, up)
    roll = atan2(-side_b, up) if across > _UPRIGHT * GRAVITY_M_S2 else nan
    return roll, atan2(along, across)


def differs(old: Environment, new: Environment) -> bool:
    """Return whether a report says more than noise would."""
    return (
        old.segment != new.segment
        or _has_moved(old.roll_rad, new.roll_rad, _NOISE_RAD, turn=2 * pi)
        or _has_moved(old.pitch_rad, new.pitch_rad, _NOISE_RAD)
        or _has_moved(old.diameter_m, new.diameter_m, _NOISE_M)
    )


def _has_moved(old: float, new: float, noise: float, turn: float = inf) -> bool:
    """Return whether a value differs by more than noise, or has become known or unknown."""
    if isnan(old) or isnan(new):
        return isnan(old) != isnan(new)
    return abs(remainder(new - old, turn)) > noise
