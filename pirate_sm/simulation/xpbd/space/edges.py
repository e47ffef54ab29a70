"""Edges of a pipe as lines of points for the kernel: of mitres, tees, reducers and open ends."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from pirate_sm.geometry.space import Frame, Vector, dot
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd.space import kernel
from pirate_sm.simulation.xpbd.space.solids import Hole

MITRE_POINTS = 65
"""Of the inner half of an ellipse; in 120 mm they are 3 mm apart and 0.02 mm off it."""
RING_POINTS = 96


class Edge(NamedTuple):
    """A line on which the walls of a pipe meet, pointing into it.

    Attributes:
        points: Its points, and the direction into the pipe at each.
        solids: The numbers of the two solids that meet; -1 for none.
        closed: Whether its last point is followed by its first one.
    """

    points: tuple[tuple[Vector, Vector], ...]
    solids: tuple[int, int]
    closed: bool


def mitre_edge(before: Frame, after: Frame, radius_m: float, solids: tuple[int, int]) -> Edge:
    """Return the inner half of the ellipse in which the pipes of a mitre meet.

    Args:
        before: The frame of the first pipe.
        after: The frame of the second pipe, its origin in the intersection of the axes.
        radius_m: Inner radius of both.
        solids: Their numbers.
    """
    a, b, crossing = before.ahead, after.ahead, after.origin
    along = dot(a, b)
    inner = _unit(tuple(y - along * x for x, y in zip(a, b, strict=True)))
    aside = _cross(a, inner)
    # tan(angle / 2)
    slope = sqrt((1.0 - along) / (1.0 + along))
    points = []
    for k in range(MITRE_POINTS):
        angle = pi * (k / (MITRE_POINTS - 1) - 0.5)
        c, s = radius_m * cos(angle), radius_m * sin(angle)
        off = _sum((-c * slope, a), (c, inner), (s, aside))
        points.append((_sum((1.0, crossing), (1.0, off)), _unit(_sum((-1.0, off)))))
    return Edge(tuple(points), solids, closed=False)


def ring(frame: Frame, radius_m: float, solids: tuple[int, int]) -> Edge:
    """Return a circle across a pipe: the narrow end of a reducer, or the rim of an open end."""
    points = []
    for k in range(RING_POINTS):
        angle = 2.0 * pi * k / RING_POINTS
        off = _sum((cos(angle), frame.side), (sin(angle), frame.normal))
        points.append((_sum((1.0, frame.origin), (radius_m, off)), _sum((-1.0, off))))
    return Edge(tuple(points), solids, closed=True)


def mouth(main: Hole, branch: Hole, solids: tuple[int, int]) -> Edge:
    """Return the line in which the branch of a tee meets its main pipe.

    Args:
        main: The main pipe; its point is where the axes meet.
        branch: The branch, no wider than the main pipe.
        solids: The numbers of the main pipe and of the branch.
    """
    t, b, radius = main.direction, branch.direction, branch.radius_m
    along = dot(t, b)
    first = _unit(tuple(x - along * y for x, y in zip(t, b, strict=True)))
    second = _cross(b, first)
    points = []
    for k in range(RING_POINTS):
        angle = 2.0 * pi * k / RING_POINTS
        outwards = _sum((cos(angle), first), (sin(angle), second))
        off = _sum((radius, outwards))
        # Where the line along the branch comes out of the main pipe.
        flat, steep = _square_to(off, t), _square_to(b, t)
        half = dot(flat, steep)
        square = dot(steep, steep)
        left = half * half - square * (dot(flat, flat) - main.radius_m**2)
        height = (-half + sqrt(max(left, 0.0))) / square
        off = _sum((1.0, off), (height, b))
        into = _sum((-1.0, outwards), (-1.0, _unit(_square_to(off, t))))
        points.append((_sum((1.0, main.point), (1.0, off)), _unit(into)))
    return Edge(tuple(points), solids, closed=True)


def edge_rows(edges: Sequence[Edge]) -> tuple[Floats, Floats]:
    """Return edges and their points for the kernel.

    The first is `(edges, kernel.EDGE_COLUMNS)`, the second `(points, kernel.POINT_COLUMNS)`.
    """
    rows = np.zeros((len(edges), kernel.EDGE_COLUMNS))
    first, points = 0, []
    for row, edge in zip(rows, edges, strict=True):
        places = np.array([place for place, _ in edge.points])
        middle = (places.min(axis=0) + places.max(axis=0)) / 2.0
        away = float(np.linalg.norm(places - middle, axis=1).max())
        row[:] = (first, len(edge.points), float(edge.closed), *edge.solids, *middle, away)
        points += [(*place, *into) for place, into in edge.points]
        first += len(edge.points)
    return rows, np.array(points).reshape(-1, kernel.POINT_COLUMNS)


def _sum(*shares: tuple[float, Sequence[float]]) -> Vector:
    x = sum(share * each[0] for share, each in shares)
    y = sum(share * each[1] for share, each in shares)
    z = sum(share * each[2] for share, each in shares)
    return x, y, z


def _unit(vector: Sequence[float]) -> Vector:
    return _sum((1.0 / hypot(*vector), vector))


def _cross(one: Vector, other: Vector) -> Vector:
    (ax, ay, az), (bx, by, bz) = one, other
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def _square_to(vector: Vector, axis: Vector) -> Vector:
    return _sum((1.0, vector), (-dot(vector, axis), axis))
