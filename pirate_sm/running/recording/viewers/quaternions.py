"""Rotations as unit quaternions, as viewers take them: x, y, z, w."""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import Any, Literal, NamedTuple

from pirate_sm.core.geometry import Vector


class Quaternion(NamedTuple):
    """A rotation; all four are 0, 0, 0, 1 without one."""

    x: float
    y: float
    z: float
    w: float

    @property
    def json(self) -> dict[str, Any]:
        """Return it as JSON."""
        return self._asdict()


def about(axis: Literal["x", "z"], angle_rad: float) -> Quaternion:
    """Return the rotation about a coordinate axis."""
    half = angle_rad / 2
    if axis == "x":
        return Quaternion(sin(half), 0.0, 0.0, cos(half))
    return Quaternion(0.0, 0.0, sin(half), cos(half))


def of_axes(x: Vector, y: Vector, z: Vector) -> Quaternion:
    """Return the rotation that takes the coordinate axes to three orthogonal unit vectors.

    By the largest of the four numbers (S. W. Shepperd, 1978), so that none is divided by a small
    one.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = x, y, z
    trace = xx + yy + zz
    squares = (1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + trace)
    largest = squares.index(max(squares))
    s = 2.0 * sqrt(squares[largest])
    if largest == 0:
        return Quaternion(s / 4, (xy + yx) / s, (xz + zx) / s, (yz - zy) / s)
    if largest == 1:
        return Quaternion((xy + yx) / s, s / 4, (yz + zy) / s, (zx - xz) / s)
    if largest == 2:
        return Quaternion((xz + zx) / s, (yz + zy) / s, s / 4, (xy - yx) / s)
    return Quaternion((yz - zy) / s, (zx - xz) / s, (xy - yx) / s, s / 4)
