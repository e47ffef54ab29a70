"""Views of pipes in space: from above, from the side, and unrolled along the way."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import atan2
from typing import TypeAlias

from pirate_sm.core._geometry.plane import Walls
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import (
    DRAWING,
    Frame,
    Place,
    Vector,
    between,
    combined,
    crossed,
    dot,
    scaled,
)
from pirate_sm.core._geometry.tube_rings import Rings

Outline: TypeAlias = tuple[Place, ...]
"""The corners of a convex area."""

_STRAIGHT = 1e-8
"""Corners that stick out by less are left out."""

_STEEP = 0.2
"""Sine of the angle to the vertical below which a pipe has no upper side."""


def upright(up: Vector) -> Frame:
    """Return the frame whose ``normal`` goes up and whose ``ahead`` is level.

    ``ahead`` is that of the drawing as seen from above, or its side A if the first run is upright.
    ``side`` is on the left.
    """
    ahead = DRAWING.ahead if abs(up[0]) < 1.0 - 1e-6 else DRAWING.side
    level = combined((1.0, ahead), (-dot(ahead, up), up))
    level = scaled(dot(level, level) ** -0.5, level)
    return Frame(DRAWING.origin, level, crossed(up, level), up)


def seen_in(frame: Frame, point: Vector) -> Vector:
    """Return the coordinates of a point, or of a direction, along the axes of a frame."""
    return dot(point, frame.ahead), dot(point, frame.side), dot(point, frame.normal)


def outlines(tubes: Iterable[Rings], axes: tuple[int, int]) -> tuple[Outline, ...]:
    """Return convex areas that together are what is seen of pipes along the third axis.

    Args:
        tubes: The rings of each piece of pipe.
        axes: The two axes of the picture.
    """
    one, other = axes
    return tuple(
        _hull([(point[one], point[other]) for ring in pair for point in ring])
        for rings in tubes
        for pair in pairwise(rings)
    )


def _hull(points: Sequence[Place]) -> Outline:
    """Return the convex hull of points, counter-clockwise (A. M. Andrew, 1979)."""
    ordered = sorted({(round(x, 6), round(y, 6)) for x, y in points})
    return (*_chain(ordered)[:-1], *_chain(ordered[::-1])[:-1])


def _chain(points: Sequence[Place]) -> list[Place]:
    found: list[Place] = []
    for x, y in points:
        while len(found) > 1:
            (ax, ay), (bx, by) = found[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > _STRAIGHT:
                break
            found.pop()
        found.append((x, y))
    return found


def unrolled(route: Route, point: Vector, roll_rad: float) -> Place:
    """Return how far a point is along a route, and how far to side A of a part so rolled, m."""
    arc_m, _ = route.nearest(point)
    frame = route.frame_at(arc_m)
    return arc_m, dot(between(frame.origin, point), frame.towards(roll_rad))


def unrolled_walls(route: Route) -> Walls:
    """Return the walls of a route on either side of its unrolled axis, m."""
    first = route.pieces[0]
    one = [(first.arc_m, first.diameter_m / 2)]
    for piece in route.pieces:
        for corner in (piece.arc_m, piece.diameter_m / 2), (piece.ends_m, piece.ends_with_m / 2):
            if corner != one[-1]:
                one.append(corner)
    return tuple(one), tuple((x, -y) for x, y in one)


def clock_rad(route: Route, arc_m: float, roll_rad: float) -> float:
    """Return where a direction across a route points, looking ahead: 0 right, 90 deg up.

    In an upright pipe, which has no upper side, it is the roll against the frame of the pipe.

    Args:
        route: The route.
        arc_m: Where on it.
        roll_rad: Roll of the direction about the direction of travel; 0 is towards side A.
    """
    frame = route.frame_at(arc_m)
    across = combined((1.0, route.up), (-dot(route.up, frame.ahead), frame.ahead))
    if dot(across, across) < _STEEP**2:
        return roll_rad
    highest = frame.roll_of(across)
    direction = frame.rolled(highest).roll_of(frame.towards(roll_rad))
    return atan2(1.0, 0.0) + direction
