"""Edges of a pipe as lines of points for the kernel: of mitres, tees, reducers and open ends."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

from pirate_sm.core.geometry import Frame, Vector, combined, crossed, dot, scaled
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd.space import columns
from pirate_sm.simulation.xpbd.space.solids import Hole

MITRE_POINTS = 65
"""Of the inner half of an ellipse; in 120 mm they are 3 mm apart and 0.02 mm off it."""
RING_POINTS = 96
_MEETING = 3


class WallEdge(NamedTuple):
    """A line on which the walls of a pipe meet, pointing into it.

    Attributes:
        points: Its points, and the direction into the pipe at each.
        solids: The numbers of the solids that meet there, at most three.
        closed: Whether its last point is followed by its first one.
    """

    points: tuple[tuple[Vector, Vector], ...]
    solids: tuple[int, ...]
    closed: bool


def mitre_edge(before: Frame, after: Frame, radius_m: float, solids: tuple[int, ...]) -> WallEdge:
    """Return the inner half of the ellipse in which the pipes of a mitre meet.

    Args:
        before: The frame of the first pipe.
        after: The frame of the second pipe, its origin in the intersection of the axes.
        radius_m: Inner radius of both.
        solids: Their numbers.
    """
    a, b, crossing = before.ahead, after.ahead, after.origin
    along = dot(a, b)
    inner = _unit(_square_to(b, a))
    aside = crossed(a, inner)
    # tan(angle / 2)
    slope = sqrt((1.0 - along) / (1.0 + along))
    points = []
    for k in range(MITRE_POINTS):
        angle = pi * (k / (MITRE_POINTS - 1) - 0.5)
        c, s = radius_m * cos(angle), radius_m * sin(angle)
        off = combined((-c * slope, a), (c, inner), (s, aside))
        points.append((combined((1.0, crossing), (1.0, off)), _unit(scaled(-1.0, off))))
    return WallEdge(tuple(points), solids, closed=False)


def ring(frame: Frame, radius_m: float, solids: tuple[int, ...]) -> WallEdge:
    """Return a circle across a pipe: the narrow end of a reducer, or the rim of an open end."""
    points = []
    for k in range(RING_POINTS):
        angle = 2.0 * pi * k / RING_POINTS
        off = combined((cos(angle), frame.side), (sin(angle), frame.normal))
        points.append((combined((1.0, frame.origin), (radius_m, off)), scaled(-1.0, off)))
    return WallEdge(tuple(points), solids, closed=True)


def mouth(main: Hole, branch: Hole, solids: tuple[int, ...]) -> WallEdge:
    """Return the line in which the branch of a tee meets its main pipe.

    Args:
        main: The main pipe; its point is where the axes meet.
        branch: The branch, no wider than the main pipe.
        solids: The numbers of the two pipes of the main and of the branch.
    """
    t, b, radius = main.direction, branch.direction, branch.radius_m
    first = _unit(_square_to(t, b))
    second = crossed(b, first)
    points = []
    for k in range(RING_POINTS):
        angle = 2.0 * pi * k / RING_POINTS
        outwards = combined((cos(angle), first), (sin(angle), second))
        off = combined((radius, outwards))
        # Where the line along the branch comes out of the main pipe.
        flat, steep = _square_to(off, t), _square_to(b, t)
        half = dot(flat, steep)
        square = dot(steep, steep)
        left = half * half - square * (dot(flat, flat) - main.radius_m**2)
        height = (-half + sqrt(max(left, 0.0))) / square
        off = combined((1.0, off), (height, b))
        into = combined((-1.0, outwards), (-1.0, _unit(_square_to(off, t))))
        points.append((combined((1.0, main.point), (1.0, off)), _unit(into)))
    return WallEdge(tuple(points), solids, closed=True)


def edge_rows(edges: Sequence[WallEdge]) -> tuple[Floats, Floats]:
    """Return edges and their points for the kernel.

    The first is `(edges, columns.EDGE_COLUMNS)`, the second `(points, columns.POINT_COLUMNS)`.
    """
    rows = np.zeros((len(edges), columns.EDGE_COLUMNS))
    first, points = 0, []
    for row, edge in zip(rows, edges, strict=True):
        places = np.array([place for place, _ in edge.points])
        middle = (places.min(axis=0) + places.max(axis=0)) / 2.0
        away = float(np.linalg.norm(places - middle, axis=1).max())
        solids = (*edge.solids, -1, -1, -1)[:_MEETING]
        row[:] = (first, len(edge.points), float(edge.closed), *solids, *middle, away)
        points += [(*place, *into) for place, into in edge.points]
        first += len(edge.points)
    return rows, np.array(points).reshape(-1, columns.POINT_COLUMNS)


def _unit(vector: Vector) -> Vector:
    return scaled(1.0 / hypot(*vector), vector)


def _square_to(vector: Vector, axis: Vector) -> Vector:
    return combined((1.0, vector), (-dot(vector, axis), axis))
