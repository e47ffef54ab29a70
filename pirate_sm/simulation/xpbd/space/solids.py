"""Solids of a pipe as rows for the kernel: cylinders, cones, elbows and flat discs.

Each takes the frame at its beginning, where `ahead` is the axis, and returns a row of
`columns.SOLID_COLUMNS`. A wall counts where the foot of a point lies between two planes and
outside a hole.
"""

from __future__ import annotations

from math import atan2, cos, hypot, inf, sin, sqrt
from typing import NamedTuple, TypeAlias

import numpy as np

from pirate_sm.core.geometry import Arc, Frame, Vector, combined, crossed, dot
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd.space import columns


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
