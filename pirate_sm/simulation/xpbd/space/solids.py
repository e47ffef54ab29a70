"""Solids of a pipe as rows for the kernel: cylinders, cones, elbows and flat discs.

Each takes the frame at its beginning, where `ahead` is the axis, and returns a row of
`kernel.SOLID_COLUMNS`. A wall counts where the foot of a point lies between two planes and
outside a hole.
"""

from __future__ import annotations

from math import cos, hypot, inf, sin, sqrt
from typing import NamedTuple, TypeAlias

import numpy as np

from pirate_sm.geometry.space import Frame, Vector, dot
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd.space import kernel


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
    row = _row(kernel.CONE, frame.origin, frame.ahead, radius_m, (end_m - radius_m) / length_m)
    widest = max(radius_m, end_m)
    planes = (first or Plane(frame.origin, frame.ahead), last or Plane(ends, frame.ahead))
    _clip(row, *planes)
    _open(row, hole)
    more = [widest * _slope(frame.ahead, plane.direction) for plane in planes]
    begin = frame.point(-more[0])
    along = length_m + sum(more)
    row[kernel.B_X : kernel.B_RADIUS] = (*begin, *(along * each for each in frame.ahead))
    row[kernel.B_RADIUS] = widest
    return row


def elbow(
    frame: Frame, angle_rad: float, ring_m: float, radius_m: float, hole: Hole | None = None
) -> Row:
    """Return an elbow: a piece of a torus.

    Args:
        frame: Its beginning.
        angle_rad: Its angle, less than 180 deg; positive bends towards side A.
        ring_m: Radius of its centre line.
        radius_m: Inner radius of the tube.
        hole: A pipe that opens its wall.
    """
    sign = 1.0 if angle_rad > 0 else -1.0
    centre = frame.point(0.0, sign * ring_m)
    row = _row(kernel.TORUS, centre, frame.normal, radius_m, ring_m)
    _clip(row, Plane(centre, frame.ahead), Plane(centre, frame.turned(angle_rad).ahead))
    _open(row, hole)
    chord = sqrt(2.0 - 2.0 * cos(angle_rad)) * ring_m
    half = angle_rad / 2.0
    middle = frame.point(ring_m * abs(sin(half)) * cos(half), ring_m * sin(half) * sin(abs(half)))
    row[kernel.B_X : kernel.B_Z + 1] = middle
    row[kernel.B_RADIUS] = chord / 2.0 + radius_m + ring_m * (1.0 - cos(half))
    return row


def disc(frame: Frame, radius_m: float, inner_m: float = 0.0) -> Row:
    """Return a flat wall across a pipe; `frame.ahead` points into the pipe.

    Args:
        frame: Its middle.
        radius_m: Its outer radius.
        inner_m: The radius of its opening: 0 for a closed end, more for a step.
    """
    row = _row(kernel.DISC, frame.origin, frame.ahead, radius_m, inner_m)
    row[kernel.F_VALUE], row[kernel.L_VALUE] = -inf, inf
    row[kernel.B_X : kernel.B_Z + 1] = frame.origin
    row[kernel.B_RADIUS] = radius_m
    return row


def _row(kind: float, point: Vector, direction: Vector, *sizes: float) -> Row:
    row = np.zeros(kernel.SOLID_COLUMNS)
    row[: kernel.SLOPE_OR_SIZE + 1] = (kind, *point, *direction, *sizes)
    return row


def _clip(row: Row, first: Plane, last: Plane) -> None:
    row[kernel.F_X : kernel.F_VALUE + 1] = (*first.direction, dot(first.point, first.direction))
    row[kernel.L_X : kernel.L_VALUE + 1] = (*last.direction, dot(last.point, last.direction))


def _open(row: Row, hole: Hole | None) -> None:
    if hole is not None:
        row[kernel.HOLE] = kernel.WHOLE_HOLE if hole.whole else kernel.HALF_HOLE
        row[kernel.H_X : kernel.H_RADIUS + 1] = (*hole.point, *hole.direction, hole.radius_m)


def _slope(axis: Vector, direction: Vector) -> float:
    """Return the tangent of the angle between an axis and the direction of a plane."""
    along = dot(axis, direction)
    size = hypot(*direction)
    return sqrt(max(size * size - along * along, 0.0)) / abs(along)
