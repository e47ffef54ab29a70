"""Points, directions and frames in space.

A pipe is drawn in the frame of its first run: x along it, y towards side A of a robot with roll 0,
z perpendicular to both. In a horizontal pipe side A is on the right, so z points down.
"""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple, TypeAlias

Vector: TypeAlias = tuple[float, float, float]
Place: TypeAlias = tuple[float, float]
"""A point in a plane, m."""

GRAVITY_M_S2 = 9.81


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
        return self._replace(origin=self.point(along_m))

    def turned(self, angle_rad: float) -> Frame:
        """Return the frame turned about its normal; a positive angle turns towards side A."""
        ahead, side = _turned(self.ahead, self.side, angle_rad)
        return self._replace(ahead=ahead, side=side)

    def rolled(self, angle_rad: float) -> Frame:
        """Return the frame rolled about ``ahead``; a positive angle rolls side A to the normal."""
        side, normal = _turned(self.side, self.normal, angle_rad)
        return self._replace(side=side, normal=normal)


DRAWING = Frame((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""The frame in which a pipe is drawn."""


def dot(one: Vector, other: Vector) -> float:
    """Return the scalar product of two vectors."""
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _turned(first: Vector, second: Vector, angle_rad: float) -> tuple[Vector, Vector]:
    """Return two unit vectors rotated in their plane, from the first towards the second."""
    c, s = cos(angle_rad), sin(angle_rad)
    (ax, ay, az), (bx, by, bz) = first, second
    return (
        (c * ax + s * bx, c * ay + s * by, c * az + s * bz),
        (c * bx - s * ax, c * by - s * ay, c * bz - s * az),
    )
