"""Planes: the plane of the drawing, as a projection of space, and those of a robot's parts.

x and y are the axes of the drawing, see :mod:`pirate_sm.core._geometry.space`.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise
from math import cos, sin
from typing import TypeAlias

from pirate_sm.core._geometry.network import Piece
from pirate_sm.core._geometry.route import Route
from pirate_sm.core._geometry.space import Place, Vector

Walls: TypeAlias = tuple[tuple[Place, ...], tuple[Place, ...]]

_FLAT = 1e-9


def flat(point: Vector) -> Place:
    """Return the projection of a point into the plane of the drawing."""
    return point[0], point[1]


def turned(place: Place, angle_rad: float) -> Place:
    """Return a point rotated about the origin, from x to y."""
    (x, y), c, s = place, cos(angle_rad), sin(angle_rad)
    return x * c - y * s, x * s + y * c


def walls(route: Route) -> Walls:
    """Return the corners of the walls of a planar route on side A and on side B, m."""
    return _wall(route, 1.0), _wall(route, -1.0)


def drawn_walls(route: Route) -> tuple[tuple[Place, ...], ...]:
    """Return the walls of a route that lies in the plane of the drawing; empty for others.

    A route with elbows or changes of its diameter has no such walls either.
    """
    flat_pieces = all(
        abs(piece.frame.ahead[2]) < _FLAT
        and abs(piece.frame.origin[2]) < _FLAT
        and piece.arc is None
        and piece.ends_with_m == piece.diameter_m == route.pieces[0].diameter_m
        for piece in route.pieces
    )
    return walls(route) if flat_pieces else ()


def _wall(route: Route, side: float) -> tuple[Place, ...]:
    first, last = route.pieces[0], route.pieces[-1]
    corners = [flat(first.frame.point(0.0, side * first.diameter_m / 2))]
    for before, after in pairwise(route.pieces):
        (ax, ay), (bx, by) = flat(before.frame.ahead), flat(after.frame.ahead)
        x, y = flat(after.frame.origin)
        # The intersection of the two lines parallel to the centre line.
        share = side * before.diameter_m / 2 / (1.0 + ax * bx + ay * by)
        corners.append((x - share * (ay + by), y + share * (ax + bx)))
    corners.append(flat(last.frame.point(last.length_m, side * last.diameter_m / 2)))
    return tuple(corners)


def inner_corner(route: Route) -> Place:
    """Return the inner corner of a route's first bend; of a straight one where side A begins.

    It is the origin of the plane of a setup (thesis section 5-3-2), whose x points along the first
    leg and whose y points to side A.
    """
    side_a, side_b = walls(route)
    if len(route.pieces) == 1:
        return side_a[0]
    (ax, ay), (bx, by) = (flat(piece.frame.ahead) for piece in route.pieces[:2])
    return side_a[1] if ax * by - ay * bx > 0 else side_b[1]


def crossing(route: Route) -> tuple[Piece, Piece] | None:
    """Return the first two pieces of a planar route that overlap, None if there are none.

    Adjacent pieces meet at their fitting and are not compared.
    """
    side_a, side_b = walls(route)
    for (i, one), (k, other) in combinations(enumerate(route.pieces), 2):
        shapes = [(side_a[n], side_b[n], side_b[n + 1], side_a[n + 1]) for n in (i, k)]
        if k - i > 1 and _overlap(shapes[0], shapes[1]):
            return one, other
    return None


def _overlap(one: Sequence[Place], other: Sequence[Place]) -> bool:
    """Return whether two convex polygons overlap, by the separating axis theorem."""
    for shape in (one, other):
        for (ax, ay), (bx, by) in zip(shape, (*shape[1:], shape[0]), strict=True):
            first = [(by - ay) * x - (bx - ax) * y for x, y in one]
            second = [(by - ay) * x - (bx - ax) * y for x, y in other]
            if max(first) <= min(second) + 1e-12 or max(second) <= min(first) + 1e-12:
                return False
    return True
