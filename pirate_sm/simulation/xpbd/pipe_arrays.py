"""A planar route as arrays for the kernel: its straight pieces and their walls."""

from __future__ import annotations

import math

import numpy as np

from pirate_sm.core.geometry import GRAVITY_M_S2, Piece, Route, Vector, flat, walls
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd import columns


def leg_rows(route: Route) -> Floats:
    """Return the pieces as an array for the kernel, `(pieces, columns.LEG_COLUMNS)`."""
    return np.array([_leg_row(route, piece) for piece in route.pieces])


def wall_rows(route: Route) -> Floats:
    """Return the walls of both sides for the kernel, `(2 * pieces, columns.WALL_COLUMNS)`."""
    pieces, both = route.pieces, walls(route)
    rows = np.zeros((2 * len(pieces), columns.WALL_COLUMNS))
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


def gravity_along(piece: Piece, up: Vector) -> tuple[float, ...]:
    """Return gravity along a piece, towards side A and along the normal of the plane, m/s²."""
    (tx, ty), (up_x, up_y, up_z) = flat(piece.frame.ahead), up
    against = (up_x * tx + up_y * ty, up_y * tx - up_x * ty, up_z)
    return tuple(-GRAVITY_M_S2 * each for each in against)


def _leg_row(route: Route, piece: Piece) -> tuple[float, ...]:
    """Return a piece, and gravity in its directions."""
    ahead, gravity = flat(piece.frame.ahead), gravity_along(piece, route.up)
    return (*flat(piece.frame.origin), *ahead, piece.length_m, piece.arc_m, *gravity)
