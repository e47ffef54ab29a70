"""Solids and edges of a pipe as rows for the kernel: tubes, elbows and discs, and where they end.

Each solid takes the frame at its beginning, where `ahead` is the axis, and returns a row of
`columns.SOLID_COLUMNS`. A wall counts where the foot of a point lies between two planes and
outside a hole. Edges are lines of points.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple, TypeAlias

import numpy as np

from pirate_sm.core.geometry import Arc, Frame, Vector, combined, crossed, dot, scaled
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic.space import columns


class Plane(NamedTuple):
    """A plane across a pipe; `direction` is along the direction of travel."""

    point: Vector
    direction: Vector


class Hole(NamedTuple):
    """Another pipe that opens a wall.

    Attributes:
        point: A point of its axis.
        direction: Direction of its axis, a unit vector.
        radius_m: Its inner radius.
        whole: Whether it goes both ways from the point, as the main pipe of a tee does; a branch
            begins at the point.
    """

    point: Vector
    direction: Vector
    radius_m: float
    whole: bool = False


Row: TypeAlias = Floats


def tube(
    frame: Frame,
    length_m: float,
    radius_m: float,
    to_radius_m: float | None = None,
    *,
    first: Plane | None = None,
    last: Plane | None = None,
    hole: Hole | None = None,
) -> Row:
    """Return a cylinder, or a cone where its two radii differ.

    Args:
        frame: Its beginning.
        length_m: Its length along the axis.
        radius_m: Inner radius at its beginning.
        to_radius_m: Inner radius at its end; that of its beginning if omitted.
        first: The plane where its wall begins; by default across its beginning.
        last: The plane where its wall ends; by default across its end.
        hole: A pipe that opens its wall.
    """
    end_m = radius_m if to_radius_m is None else to_radius_m
    ends = frame.point(length_m)
    row = _row(columns.CONE, frame.origin, frame.ahead, radius_m, (end_m - radius_m) / length_m)
    row[columns.COSINE] = cos(atan2(end_m - radius_m, length_m))
    widest = max(radius_m, end_m)
    planes = (first or Plane(frame.origin, frame.ahead), last or Plane(ends, frame.ahead))
    _clip(row, *planes)
    _open(row, hole)
    more = [widest * _slope(frame.ahead, plane.direction) for plane in planes]
    begin = frame.point(-more[0])
    along = length_m + sum(more)
    row[columns.B_X : columns.B_RADIUS] = (*begin, *(along * each for each in frame.ahead))
    row[columns.B_RADIUS] = widest
    return row


def elbow(frame: Frame, arc: Arc, radius_m: float, hole: Hole | None = None) -> Row:
    """Return an elbow: a piece of a torus.

    Args:
        frame: Its beginning.
        arc: Its centre line, up to half a turn.
        radius_m: Inner radius of the tube.
        hole: A pipe that opens its wall.
    """
    centre = combined((1.0, frame.origin), (arc.radius_m, arc.towards))
    axis = crossed(frame.ahead, arc.towards)
    row = _row(columns.TORUS, centre, axis, radius_m, arc.radius_m)
    after = frame.bent(arc.towards, arc.angle_rad).ahead
    _clip(row, Plane(centre, frame.ahead), Plane(centre, after))
    _open(row, hole)
    half = arc.angle_rad / 2.0
    # The middle of the arc; no place of the centre line is farther away than its ends.
    forward, inward = arc.radius_m * sin(half), arc.radius_m * (1.0 - cos(half))
    middle = combined((1.0, frame.origin), (forward, frame.ahead), (inward, arc.towards))
    row[columns.B_X : columns.B_Z + 1] = middle
    row[columns.B_RADIUS] = hypot(forward, inward) + radius_m
    return row


def disc(frame: Frame, radius_m: float, inner_m: float = 0.0) -> Row:
    """Return a flat wall across a pipe; `frame.ahead` points into the pipe.

    Args:
        frame: Its middle.
        radius_m: Its outer radius.
        inner_m: The radius of its opening: 0 for a closed end, more for a step.
    """
    row = _row(columns.DISC, frame.origin, frame.ahead, radius_m, inner_m)
    row[columns.F_VALUE], row[columns.L_VALUE] = -inf, inf
    row[columns.B_X : columns.B_Z + 1] = frame.origin
    row[columns.B_RADIUS] = radius_m
    return row


def _row(kind: float, point: Vector, direction: Vector, *sizes: float) -> Row:
    row = np.zeros(columns.SOLID_COLUMNS)
    row[: columns.SLOPE_OR_SIZE + 1] = (kind, *point, *direction, *sizes)
    return row


def _clip(row: Row, first: Plane, last: Plane) -> None:
    row[columns.F_X : columns.F_VALUE + 1] = (*first.direction, dot(first.point, first.direction))
    row[columns.L_X : columns.L_VALUE + 1] = (*last.direction, dot(last.point, last.direction))


def _open(row: Row, hole: Hole | None) -> None:
    if hole is not None:
        row[columns.HOLE] = columns.WHOLE_HOLE if hole.whole else columns.HALF_HOLE
        row[columns.H_X : columns.H_RADIUS + 1] = (*hole.point, *hole.direction, hole.radius_m)


def _slope(axis: Vector, direction: Vector) -> float:
    """Return the tangent of the angle between an axis and the direction of a plane."""
    along = dot(axis, direction)
    size = hypot(*direction)
    return sqrt(max(size * size - along * along, 0.0)) / abs(along)


# --- edges ---------------------------------------------------------------------------------------


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
