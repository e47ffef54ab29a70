"""A pipe as the arrays that the kernel takes: its straight pieces and their walls."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pirate_sm.backends.simulator import kernel
from pirate_sm.backends.simulator.arrays import Floats
from pirate_sm.errors import UsageError
from pirate_sm.geometry.network import Network
from pirate_sm.geometry.plane import Walls, flat, walls
from pirate_sm.geometry.route import Piece, Route
from pirate_sm.geometry.space import GRAVITY_M_S2, Place

# 120 deg, and what rounding adds to it.
_SHARPEST_RAD = math.radians(120) + 1e-6


class Pipe(Route):
    """The only route of a planar network.

    Attributes:
        diameter_m: Inner diameter.
        wall_a: Corners of the wall on side A, m.
        wall_b: Corners of the wall on side B, m.
        leg_array: Its pieces for the kernel, `(pieces, kernel.LEG_COLUMNS)`.
        wall_array: Walls for the kernel, `(2 * pieces, kernel.WALL_COLUMNS)`.

    Raises:
        UsageError: A straight is too short for the mitres at its ends, or a bend is too sharp.
    """

    def __init__(self, network: Network) -> None:
        super().__init__(network)
        _check(self.pieces)
        self.diameter_m = self.pieces[0].diameter_m
        self.wall_a, self.wall_b = both = walls(self)
        self.leg_array: Floats = np.array([_leg_row(self, piece) for piece in self.pieces])
        self.wall_array = _wall_rows(self.pieces, both)

    def point(self, arc_m: float, aside_m: float = 0.0) -> Place:
        """Return the drawing's point at an arc length, so far to side A of the centre line."""
        return flat(self.piece_at(arc_m).point(arc_m, aside_m))


def _leg_row(route: Route, piece: Piece) -> tuple[float, ...]:
    """Return a piece, and gravity along it, towards side A and along the normal of the plane."""
    (tx, ty), (up_x, up_y, up_z) = flat(piece.frame.ahead), route.up
    gravity = [-GRAVITY_M_S2 * up for up in (up_x * tx + up_y * ty, up_y * tx - up_x * ty, up_z)]
    return (*flat(piece.frame.origin), tx, ty, piece.length_m, piece.arc_m, *gravity)


def _wall_rows(pieces: Sequence[Piece], both: Walls) -> Floats:
    rows = np.zeros((2 * len(pieces), kernel.WALL_COLUMNS))
    for i, piece in enumerate(pieces):
        for side, wall in enumerate(both):
            (x0, y0), (x1, y1) = wall[i], wall[i + 1]
            sign = -1.0 if side == 0 else 1.0
            tx, ty = flat(piece.frame.ahead)
            row = rows[2 * i + side]
            row[:7] = (x0, y0, tx, ty, math.hypot(x1 - x0, y1 - y0), -ty * sign, tx * sign)
            if piece.bend is None:
                continue
            inner = (piece.bend.angle_rad > 0) == (side == 0)
            nx, ny = flat(pieces[i + 1].frame.ahead)
            bisector = (sign * (-ty - ny), sign * (tx + nx))
            norm = math.hypot(*bisector)
            row[7:] = (float(inner), nx, ny, bisector[0] / norm, bisector[1] / norm)
    return rows


def _check(pieces: Sequence[Piece]) -> None:
    for number, piece in enumerate(pieces, start=1):
        if piece.bend is not None and not 0.0 < abs(piece.bend.angle_rad) <= _SHARPEST_RAD:
            raise UsageError(f"mitre {number} must turn by more than 0 and at most 120 deg")
        least_m = sum(piece.taken_m)
        if piece.length_m <= least_m:
            raise UsageError(
                f"straight {number} is {piece.length_m * 1000:.0f} mm long; the walls of its mitres"
                f" meet unless it is longer than {least_m * 1000:.0f} mm"
            )
