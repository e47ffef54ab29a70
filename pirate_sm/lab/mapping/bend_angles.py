"""How two legs meet, and the angle of a bend whose place words give, from the joint angles."""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, cos, nan, radians, sin
from typing import NamedTuple

from pirate_sm.core.geometry import Frame, Vector, between, combined, crossed, dot, scaled
from pirate_sm.core.sensing import BodySpec, RobotLook
from pirate_sm.lab.mapping.axes import axis_at, axis_of, meeting, plane_of, wheel_at
from pirate_sm.lab.mapping.legs import MappedBend

# --- how legs meet -------------------------------------------------------------------------------
# Both ways need one part that lies along its leg: its axis. ``leads`` is 1 where the front part
# has gone first into the other leg, -1 where the rear part has.


BEND_RAD = radians(20)
"""The least angle of a bend; a smaller one may be a slanting part [decided]."""


class ReachedBend(NamedTuple):
    """A bend, as the part shows it that has gone first into the other leg.

    Attributes:
        angle_rad: The angle of the bend.
        towards_rad: The roll towards which it turns, in the plane of the part that lies along.
        away_m: Distance from the middle of that part to the bend.
        beyond_m: Distance from the bend to the middle of the outermost link in the other leg.
    """

    angle_rad: float
    towards_rad: float
    away_m: float
    beyond_m: float


def outermost(body: BodySpec, part: int, leads: int) -> tuple[int, ...]:
    """Return the wheels of a part's link that is farthest ahead, or farthest behind."""
    wheels = body.wheels_of(part)
    return wheels[:2] if leads > 0 else wheels[-2:]


def reached(
    body: BodySpec, numbers: Sequence[float], axis: Frame, part: int, leads: int, diameter_m: float
) -> ReachedBend | None:
    """Return the bend ahead of a part that lies along its leg; None if there is none.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI.
        axis: The axis at the part that lies along its leg.
        part: The part that has gone first; its outermost link spans from wall to wall.
        leads: Which part that is.
        diameter_m: Inner diameter of the other leg.
    """
    own = axis_of(body, numbers, outermost(body, part, leads), diameter_m)
    if own is None or angle_between(own, axis) < BEND_RAD:
        return None
    if leads > 0:
        met = meeting(axis, own)
        towards = axis.roll_of(_across(own.ahead, axis.ahead))
        return ReachedBend(met.angle_rad, towards, met.behind_m, met.ahead_m)
    met = meeting(own, axis)
    towards = axis.roll_of(scaled(-1.0, _across(own.ahead, axis.ahead)))
    return ReachedBend(met.angle_rad, towards, met.ahead_m, met.behind_m)


def away_by_last_wheel(
    body: BodySpec,
    numbers: Sequence[float],
    axis: Frame,
    last: int,
    bend: ReachedBend,
    leads: int,
    diameter_m: float,
) -> float:
    """Return how far beyond a bend the part is that went first, m; NaN if that is not shown.

    The outermost wheel of the part that comes last still touches its wall in the leg behind.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI.
        axis: The axis at the part that went first, which now lies along its leg.
        last: The part that comes last.
        bend: The bend; its direction is against the plane of the part that went first.
        leads: Which part went first.
        diameter_m: Inner diameter of the leg behind.
    """
    wheels = body.wheels_of(last)
    wheel = wheels[-1] if leads > 0 else wheels[0]
    angle = bend.angle_rad
    towards = axis.towards(bend.towards_rad)
    other = combined((cos(angle), axis.ahead), (-leads * sin(angle), towards))
    side = crossed(plane_of(body, numbers, last).normal, other)
    slope = dot(axis.ahead, side)
    if abs(slope) < sin(BEND_RAD):
        return nan
    place = between(axis.origin, wheel_at(body, numbers, wheel))
    aside_m = body.sides[wheel] * (diameter_m / 2 - body.wheel_radius_m)
    return leads * (aside_m - dot(place, side)) / slope


def angle_between(one: Frame, other: Frame) -> float:
    """Return the angle between two axes, rad."""
    return acos(max(-1.0, min(1.0, dot(one.ahead, other.ahead))))


def _across(direction: Vector, axis: Vector) -> Vector:
    """Return the part of a direction across an axis."""
    return combined((1.0, direction), (-dot(direction, axis), axis))


# --- bend angles ---------------------------------------------------------------------------------


_BESIDE_RAD = radians(4)
"""The slope of a link and its direction from the corner agree up to this angle, unless the part
is off the axis of a round pipe: then the link is less oblique [decided]."""

_MOST_SHARE = 0.8
"""A part that is farther into an elbow does not show its angle [decided]."""

_ROUNDS = 9
"""Walls of an elbow's ends depend on its angle, and that on them: it converges [decided]."""


def angle_of_corner(
    body: BodySpec,
    numbers: Sequence[float],
    corner: Frame,
    part: int,
    leads: int,
    sloping_rad: float,
) -> float:
    """Return the angle of a corner, rad, by the direction from it to a part that has gone first.

    The middle of its outermost link is on the axis of the other leg also where the link is not
    oblique enough. Where the link's own slope agrees, both count.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI.
        corner: The axis of the leg behind, at the corner.
        part: The part that has gone first.
        leads: 1 if that is the front part, -1 if it is the rear part.
        sloping_rad: The angle as the link's slope shows it.
    """
    wheels = outermost(body, part, leads)
    places = [wheel_at(body, numbers, wheel) for wheel in wheels]
    halfway = combined(*((1 / len(places), place) for place in places))
    away = between(corner.origin, halfway)
    cosine = leads * dot(away, corner.ahead) / dot(away, away) ** 0.5
    seen_rad = acos(max(-1.0, min(1.0, cosine)))
    alike = abs(seen_rad - sloping_rad) < _BESIDE_RAD
    return (seen_rad + sloping_rad) / 2 if alike else seen_rad


def angle_of_elbow(
    body: BodySpec,
    numbers: Sequence[float],
    elbow: MappedBend,
    parts: tuple[int, int],
    into_m: float,
    diameter_m: float,
) -> float:
    """Return an estimate of the angle of an elbow in which the part that comes last is, rad.

    The axes at the two parts differ by what the last part has not been turned yet: its share of the
    angle is that of the elbow's length which is ahead of it. An error of 10 mm is one of 5 deg.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI.
        elbow: The elbow, with its extent.
        parts: The part that has left it, and the part that is in it.
        into_m: How far the middle of the last part is beyond the place that words count from.
        diameter_m: The inner diameter.
    """
    first, last = (axis_at(body, numbers, part) for part in parts)
    if first is None or last is None:
        return elbow.angle_rad
    found = elbow
    for _ in range(_ROUNDS):
        share = (into_m + found.wall_m(diameter_m)) / found.arc_m(diameter_m)
        ahead = 1.0 - min(max(share, 0.0), _MOST_SHARE)
        found = MappedBend(angle_between(first, last) / ahead, 0.0, extent_m=elbow.extent_m)
    return found.angle_rad


def apart_rad(body: BodySpec, look: RobotLook) -> float:
    """Return by how much the axes of the held parts differ; 0 if fewer than two are known."""
    axes = [axis_at(body, look.numbers, part) for part in sorted(look.held)]
    known = [axis for axis in axes if axis is not None]
    return max((angle_between(known[0], axis) for axis in known[1:]), default=0.0)
