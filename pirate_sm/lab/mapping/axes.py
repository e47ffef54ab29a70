"""The axis of the pipe at the clamped parts of a robot, from its joints and wheels.

A clamped part stands as a V between the walls, so its wheels show the axis of its straight: in
space, through a roll joint. Two parts in two straights show where these meet, and at which angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import acos, inf, isnan, nan
from typing import NamedTuple

from pirate_sm.core.geometry import DRAWING, Frame, Vector, between, combined, dot, turned
from pirate_sm.core.sensing import BodySpec


class Meeting(NamedTuple):
    """Where the axes at two parts come nearest to each other.

    Attributes:
        angle_rad: The angle between them, 0 to pi.
        behind_m: Distance along the axis of the part behind, from its middle to that place.
        ahead_m: Distance along the axis of the part ahead, from that place to its middle.
        apart_m: How far the axes pass each other there.
    """

    angle_rad: float
    behind_m: float
    ahead_m: float
    apart_m: float


def axis_at(body: BodySpec, numbers: Sequence[float], part: int) -> Frame | None:
    """Return the axis of the pipe at a clamped part; see :func:`axis_of`."""
    vee = body.parts[part]
    diameter_m = numbers[vee.diameter] if vee.diameter >= 0 else nan
    return axis_of(body, numbers, vee.wheels, diameter_m)


def axis_of(
    body: BodySpec, numbers: Sequence[float], wheels: Sequence[int], diameter_m: float
) -> Frame | None:
    """Return the axis of a pipe whose walls these wheels touch; None if it is unknown.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI; NaN is unknown.
        wheels: Wheels of one part, front to rear; each touches its side.
        diameter_m: Inner diameter of the pipe.

    Returns:
        The frame of the axis at the middle of the wheels, which lie in the plane of ``ahead`` and
        ``side``. Its coordinates are those of the rear half of the link with the roll joint, or of
        the first link: its front wheel is the origin, x is ahead along it.
    """
    places = body.places(body.angles(numbers), max(body.roll_link, 0))
    aside_m = diameter_m / 2 - body.wheel_radius_m
    turn = body.lean(places, wheels, aside_m)
    laid = [turned(places[wheel], turn) for wheel in wheels]
    along = sum(x for x, _ in laid) / len(laid)
    asides = [y - body.sides[wheel] * aside_m for wheel, (_, y) in zip(wheels, laid, strict=True)]
    x, y = turned((along, sum(asides) / len(laid)), -turn)
    plane = _plane_of(body, numbers, wheels[0])
    if isnan(x + y) or isnan(plane.side[1]):
        return None
    return plane.turned(-turn)._replace(origin=plane.point(x, y))


def wheel_at(body: BodySpec, numbers: Sequence[float], wheel: int) -> Vector:
    """Return the place of a wheel in the coordinates of :func:`axis_of`, m; NaN is unknown."""
    places = body.places(body.angles(numbers), max(body.roll_link, 0))
    return _plane_of(body, numbers, wheel).point(*places[wheel])


def plane_of(body: BodySpec, numbers: Sequence[float], part: int) -> Frame:
    """Return the frame in whose plane a part lies, in the coordinates of :func:`axis_of`."""
    return _plane_of(body, numbers, body.parts[part].wheels[0])


def _plane_of(body: BodySpec, numbers: Sequence[float], wheel: int) -> Frame:
    if body.roll < 0 or wheel > body.roll_link:
        return DRAWING
    return DRAWING.rolled(numbers[body.roll])


def meeting(behind: Frame, ahead: Frame) -> Meeting:
    """Return where two axes come nearest to each other; of parallel ones the place is infinite."""
    cosine = max(-1.0, min(1.0, dot(behind.ahead, ahead.ahead)))
    sine2 = 1.0 - cosine * cosine
    offset = between(behind.origin, ahead.origin)
    along, back = dot(offset, behind.ahead), dot(offset, ahead.ahead)
    if sine2 <= 0.0:
        return Meeting(acos(cosine), inf, inf, 0.0)
    first_m = (along - cosine * back) / sine2
    second_m = (back - cosine * along) / sine2
    gap = combined((1.0, offset), (-first_m, behind.ahead), (-second_m, ahead.ahead))
    return Meeting(acos(cosine), first_m, second_m, dot(gap, gap) ** 0.5)
