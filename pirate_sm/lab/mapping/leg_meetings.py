"""How two legs meet, from the joint angles at one time.

Both ways need one part that lies along its leg: its axis. ``leads`` is 1 where the front part has
gone first into the other leg, -1 where the rear part has.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, cos, nan, radians, sin
from typing import NamedTuple

from pirate_sm.core.geometry import Frame, Vector, between, combined, crossed, dot, scaled
from pirate_sm.core.sensing import BodySpec, axis_of, meeting, plane_of, wheel_at

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
        part: The part that has gone first; its outermost link stands from wall to wall.
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
