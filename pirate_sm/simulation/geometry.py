"""Where a pipe's walls and centre line are, and which way gravity pulls in each of its legs.

The pipe lies in a plane: x along the first leg, y towards side A of a robot with roll 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pirate_sm.errors import UsageError
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd import kernel

GRAVITY_M_S2 = 9.81
# 120 deg, and what rounding adds to it.
_SHARPEST_RAD = math.radians(120) + 1e-6

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Straight:
    """A piece of straight pipe, measured along the centre line up to the crossing of the axes."""

    length_m: float


@dataclass(frozen=True)
class Mitre:
    """A sharp bend of two pipes cut at half the angle.

    Attributes:
        angle_rad: How far the axis turns; positive towards side A of a robot with roll 0.
    """

    angle_rad: float


@dataclass(frozen=True)
class PipeShape:
    """A pipe in one plane with two open ends.

    Attributes:
        diameter_m: Inner diameter.
        parts: Straights and mitres; a straight first and last, and between any two mitres.
        tilt_rad: Angle between the plane of the pipe and the horizontal. Gravity in the plane is
            g sin(tilt).
        uphill_rad: Direction in the plane that goes up when tilted, from the first leg towards
            side A: 0 = the first leg goes up, 90 deg = the far leg of a 90 deg mitre goes up.
    """

    diameter_m: float
    parts: tuple[Straight | Mitre, ...]
    tilt_rad: float = 0.0
    uphill_rad: float = math.pi / 2


@dataclass(frozen=True)
class Leg:
    """A straight part of the centre line in the drawing, and gravity along its own axes.

    Attributes:
        start: Where it begins, m.
        direction: Unit vector in the drawing.
        length_m: Its length.
        arc_m: Arc length of the pipe at which it begins.
        gravity: Components along the leg, towards side A and normal to both, m/s^2.
        bend: The mitre at its end, absent for the last leg.
    """

    start: tuple[float, float]
    direction: tuple[float, float]
    length_m: float
    arc_m: float
    gravity: Vector
    bend: Mitre | None


def _lengths_and_bends(parts: Sequence[Straight | Mitre]) -> list[tuple[float, Mitre | None]]:
    """Straight lengths between bends, each with the bend that ends it."""
    rows: list[tuple[float, Mitre | None]] = []
    length = 0.0
    for part in parts:
        if isinstance(part, Straight):
            length += part.length_m
        else:
            rows.append((length, part))
            length = 0.0
    rows.append((length, None))
    return rows


class Pipe:
    """The drawing of a pipe shape, as objects and as the arrays that the kernel takes.

    Attributes:
        shape: What it was made from.
        legs: Straight parts of the centre line in order.
        crossings_m: Arc lengths at which the axes cross, one per bend.
        length_m: Arc length of the whole pipe.
        wall_a: Corners of the wall on side A, m.
        wall_b: Corners of the wall on side B, m.
        leg_array: Legs for the kernel, `(legs, kernel.LEG_COLUMNS)`.
        wall_array: Walls for the kernel, `(2 * legs, kernel.WALL_COLUMNS)`.

    Raises:
        UsageError: A straight is too short for the mitres at its ends, or a bend is too sharp.
    """

    def __init__(self, shape: PipeShape) -> None:
        self.shape = shape
        self.legs = _legs(shape)
        self.crossings_m = tuple(leg.arc_m + leg.length_m for leg in self.legs if leg.bend)
        self.length_m = sum(leg.length_m for leg in self.legs)
        _check(shape, self.legs)
        radius = shape.diameter_m / 2.0
        self.wall_a = _wall(self.legs, radius)
        self.wall_b = _wall(self.legs, -radius)
        self.leg_array = np.array(
            [
                (*leg.start, *leg.direction, leg.length_m, leg.arc_m, *leg.gravity)
                for leg in self.legs
            ]
        )
        self.wall_array = self._walls()

    def _walls(self) -> Floats:
        rows = np.zeros((2 * len(self.legs), kernel.WALL_COLUMNS))
        for i, leg in enumerate(self.legs):
            for side, wall in ((0, self.wall_a), (1, self.wall_b)):
                (x0, y0), (x1, y1) = wall[i], wall[i + 1]
                sign = -1.0 if side == 0 else 1.0
                tx, ty = leg.direction
                row = rows[2 * i + side]
                row[:7] = (x0, y0, tx, ty, math.hypot(x1 - x0, y1 - y0), -ty * sign, tx * sign)
                if leg.bend is None:
                    continue
                inner = (leg.bend.angle_rad > 0) == (side == 0)
                nx, ny = self.legs[i + 1].direction
                bisector = (sign * (-ty - ny), sign * (tx + nx))
                norm = math.hypot(*bisector)
                row[7:] = (float(inner), nx, ny, bisector[0] / norm, bisector[1] / norm)
        return rows

    def point(self, arc_m: float, offset_m: float = 0.0) -> tuple[float, float]:
        """The drawing's point at an arc length, `offset_m` towards side A of the centre line."""
        leg = next((leg for leg in self.legs if arc_m <= leg.arc_m + leg.length_m), self.legs[-1])
        along = arc_m - leg.arc_m
        (x, y), (tx, ty) = leg.start, leg.direction
        return x + along * tx - offset_m * ty, y + along * ty + offset_m * tx

    def leg_at(self, arc_m: float) -> Leg:
        """The leg that an arc length lies on; beyond the ends, the first or last one."""
        return next((leg for leg in self.legs if arc_m <= leg.arc_m + leg.length_m), self.legs[-1])


def _legs(shape: PipeShape) -> tuple[Leg, ...]:
    slope = math.sin(shape.tilt_rad)
    up = (slope * math.cos(shape.uphill_rad), slope * math.sin(shape.uphill_rad))
    legs: list[Leg] = []
    x = y = arc = angle = 0.0
    for length, bend in _lengths_and_bends(shape.parts):
        tx, ty = math.cos(angle), math.sin(angle)
        gravity = (
            -GRAVITY_M_S2 * (up[0] * tx + up[1] * ty),
            -GRAVITY_M_S2 * (up[1] * tx - up[0] * ty),
            # Side A is the right-hand side in a pipe that lies flat: the normal points down.
            GRAVITY_M_S2 * math.cos(shape.tilt_rad),
        )
        legs.append(Leg((x, y), (tx, ty), length, arc, gravity, bend))
        x, y, arc = x + length * tx, y + length * ty, arc + length
        if bend is not None:
            angle += bend.angle_rad
    return tuple(legs)


def _check(shape: PipeShape, legs: Sequence[Leg]) -> None:
    radius = shape.diameter_m / 2.0
    before = 0.0
    for number, leg in enumerate(legs, start=1):
        after = 0.0
        if leg.bend is not None:
            if not 0.0 < abs(leg.bend.angle_rad) <= _SHARPEST_RAD:
                raise UsageError(f"mitre {number} must turn by more than 0 and at most 120 deg")
            after = radius * math.tan(abs(leg.bend.angle_rad) / 2.0)
        if leg.length_m <= before + after:
            raise UsageError(
                f"straight {number} is {leg.length_m * 1000:.0f} mm long; the walls of its mitres"
                f" meet unless it is longer than {(before + after) * 1000:.0f} mm"
            )
        before = after


def _wall(legs: Sequence[Leg], offset: float) -> tuple[tuple[float, float], ...]:
    """Corners of the line at an offset towards side A of the centre line."""
    first, last = legs[0], legs[-1]
    corners = [
        (first.start[0] - offset * first.direction[1], first.start[1] + offset * first.direction[0])
    ]
    for one, two in pairwise(legs):
        (ax, ay), (bx, by) = one.direction, two.direction
        scale = offset / (1.0 + ax * bx + ay * by)
        corners.append((two.start[0] - scale * (ay + by), two.start[1] + scale * (ax + bx)))
    tx, ty = last.direction
    corners.append(
        (
            last.start[0] + last.length_m * tx - offset * ty,
            last.start[1] + last.length_m * ty + offset * tx,
        )
    )
    return tuple(corners)
