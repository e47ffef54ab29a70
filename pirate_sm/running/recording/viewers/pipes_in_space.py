"""The walls of round pipes for a scene: cylinders where they are straight, else triangles."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import dist
from typing import NamedTuple

from pirate_sm.core.geometry import (
    Ring,
    Rings,
    Route,
    Vector,
    combined,
    crossed,
    dot,
    unit,
    walls_in_space,
)
from pirate_sm.running.recording.viewers.quaternions import Quaternion, of_axes

_ROUNDING_M = 1e-6


class Cylinder(NamedTuple):
    """A straight wall with square ends.

    Attributes:
        middle: The middle of its axis, m.
        turned: The rotation that takes z to its axis.
        diameter_m: Its inner diameter.
        length_m: Its length.
    """

    middle: Vector
    turned: Quaternion
    diameter_m: float
    length_m: float


class Mesh(NamedTuple):
    """A wall of any other shape.

    Attributes:
        points: The corners, m.
        triangles: For each triangle the indices of its corners.
    """

    points: tuple[Vector, ...]
    triangles: tuple[tuple[int, int, int], ...]


def walls_to_draw(route: Route) -> Iterator[Cylinder | Mesh]:
    """Yield the walls of all pipes of a route's network, in the frame of the drawing."""
    for rings in walls_in_space(route.network, route.placement):
        yield _cylinder(rings) or _mesh(rings)


def _cylinder(rings: Rings) -> Cylinder | None:
    """Return the cylinder that two rings are; None for another shape."""
    if len(rings) != 2:
        return None
    first, last = (_middle(ring) for ring in rings)
    length_m, radius_m = dist(first, last), dist(first, rings[0][0])
    if length_m < _ROUNDING_M:
        return None
    axis = unit(combined((1.0, last), (-1.0, first)))
    for middle, ring in ((first, rings[0]), (last, rings[1])):
        for point in ring:
            away = combined((1.0, point), (-1.0, middle))
            if (
                abs(dot(away, axis)) > _ROUNDING_M
                or abs(dist(point, middle) - radius_m) > _ROUNDING_M
            ):
                return None
    across = unit(combined((1.0, rings[0][0]), (-1.0, first)))
    turned = of_axes(across, crossed(axis, across), axis)
    return Cylinder(combined((0.5, first), (0.5, last)), turned, 2 * radius_m, length_m)


def _mesh(rings: Rings) -> Mesh:
    around = len(rings[0])
    triangles = []
    for ring, _ in enumerate(pairwise(rings)):
        for number in range(around):
            a, b = ring * around + number, ring * around + (number + 1) % around
            triangles += [(a, b, a + around), (b, b + around, a + around)]
    return Mesh(tuple(point for ring in rings for point in ring), tuple(triangles))


def _middle(ring: Ring) -> Vector:
    share = 1.0 / len(ring)
    return combined(*((share, point) for point in ring))
