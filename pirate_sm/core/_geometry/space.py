"""Points, directions and frames in space.

A pipe is drawn in the frame of its first run: x along it, y towards side A of a robot with roll 0,
z perpendicular to both. In a horizontal pipe side A is on the right, so z points down.
"""

from __future__ import annotations

from math import atan2, cos, sin
from typing import NamedTuple, TypeAlias

Vector: TypeAlias = tuple[float, float, float]
Place: TypeAlias = tuple[float, float]
"""A point in a plane, m."""

GRAVITY_M_S2 = 9.81
_PARALLEL = 1e-12


class Frame(NamedTuple):
    """A point with three orthogonal unit vectors.

    Attributes:
        origin: The point, m.
        ahead: The direction of travel.
        side: The direction towards side A.
        normal: ``ahead`` × ``side``.
    """

    origin: Vector
    ahead: Vector
    side: Vector
    normal: Vector

    def point(self, along_m: float, aside_m: float = 0.0) -> Vector:
        """Return the point at these distances ahead of the origin and to its side A."""
        (x, y, z), (ax, ay, az), (sx, sy, sz) = self.origin, self.ahead, self.side
        return (
            x + along_m * ax + aside_m * sx,
            y + along_m * ay + aside_m * sy,
            z + along_m * az + aside_m * sz,
        )

    def moved(self, along_m: float) -> Frame:
        """Return the frame moved ahead by this distance."""
        return Frame(self.point(along_m), self.ahead, self.side, self.normal)

    def turned(self, angle_rad: float) -> Frame:
        """Return the frame turned about its normal; a positive angle turns towards side A."""
        ahead, side = _turned(self.ahead, self.side, angle_rad)
        return Frame(self.origin, ahead, side, self.normal)

    def rolled(self, angle_rad: float) -> Frame:
        """Return the frame rolled about ``ahead``; a positive angle rolls side A off the normal.

        So side A goes up by a positive angle where the pipe lies flat.
        """
        side, normal = _turned(self.side, self.normal, -angle_rad)
        return Frame(self.origin, self.ahead, side, normal)

    def towards(self, roll_rad: float) -> Vector:
        """Return the unit vector across ``ahead`` at this roll; 0 is towards side A."""
        return self.rolled(roll_rad).side

    def roll_of(self, direction: Vector) -> float:
        """Return the roll of what a direction has across ``ahead``; see :meth:`towards`."""
        return atan2(-dot(direction, self.normal), dot(direction, self.side))

    def bent(self, towards: Vector, angle_rad: float) -> Frame:
        """Return the frame turned by an angle towards a unit vector across ``ahead``."""
        c, s = cos(angle_rad), sin(angle_rad)

        def turned(v: Vector) -> Vector:
            along, across = dot(v, self.ahead), dot(v, towards)
            forward = (c - 1.0) * along - s * across
            aside = s * along + (c - 1.0) * across
            return combined((1.0, v), (forward, self.ahead), (aside, towards))

        return Frame(self.origin, turned(self.ahead), turned(self.side), turned(self.normal))

    def reversed(self) -> Frame:
        """Return the frame of the same point for the other direction of travel."""
        return self._replace(ahead=scaled(-1.0, self.ahead), side=scaled(-1.0, self.side))

    def led_to(self, ahead: Vector) -> Frame:
        """Return the frame turned to another direction of travel, without twist."""
        along = min(1.0, max(-1.0, dot(self.ahead, ahead)))
        across = combined((1.0, ahead), (-along, self.ahead))
        length = dot(across, across) ** 0.5
        if length < _PARALLEL:
            return self
        return self.bent(scaled(1.0 / length, across), atan2(length, along))

    def carried(self, before: Frame, after: Frame) -> Frame:
        """Return the frame moved as a body that takes the frame ``before`` to ``after``."""

        def moved(v: Vector) -> Vector:
            return combined(
                *((dot(v, old), new) for old, new in zip(before[1:], after[1:], strict=True))
            )

        offset = moved(between(before.origin, self.origin))
        origin = combined((1.0, after.origin), (1.0, offset))
        return Frame(origin, moved(self.ahead), moved(self.side), moved(self.normal))


DRAWING = Frame((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""The frame in which a pipe is drawn."""


def dot(one: Vector, other: Vector) -> float:
    """Return the scalar product of two vectors."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def combined(*terms: tuple[float, Vector]) -> Vector:
    """Return the sum of vectors, each times its factor."""
    return (
        sum(factor * v[0] for factor, v in terms),
        sum(factor * v[1] for factor, v in terms),
        sum(factor * v[2] for factor, v in terms),
    )


def scaled(factor: float, vector: Vector) -> Vector:
    """Return a vector times a factor."""
    return factor * vector[0], factor * vector[1], factor * vector[2]


def crossed(one: Vector, other: Vector) -> Vector:
    """Return the vector product of two vectors."""
    (ax, ay, az), (bx, by, bz) = one, other
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def between(one: Vector, other: Vector) -> Vector:
    """Return the vector from one point to the other."""
    return other[0] - one[0], other[1] - one[1], other[2] - one[2]


def _turned(first: Vector, second: Vector, angle_rad: float) -> tuple[Vector, Vector]:
    """Return two unit vectors rotated in their plane, from the first towards the second."""
    c, s = cos(angle_rad), sin(angle_rad)
    (ax, ay, az), (bx, by, bz) = first, second
    return (
        (c * ax + s * bx, c * ay + s * by, c * az + s * bz),
        (c * bx - s * ax, c * by - s * ay, c * bz - s * az),
    )
