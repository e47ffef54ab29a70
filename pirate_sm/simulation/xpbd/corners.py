"""Contacts of links with inner corners of the pipe."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.columns import (
    CONTACT_COMPLIANCE,
    DT,
    HALF_THICKNESS,
    K_GAP,
    K_INV,
    K_NX,
    K_NY,
    K_PUSH,
    K_SHARE,
    LINK_LENGTH,
    LOOK,
    MARGIN_M,
    MASS_INV,
    W_BX,
    W_BY,
    W_CORNER,
    W_LENGTH,
    W_TX,
    W_TY,
    W_X,
    W_Y,
    X0,
    Y0,
)


@compiled
def find_corners(
    n: int, pos: Floats, walls: Floats, body: Floats, world: Floats, cor: Floats, who: Ints
) -> int:
    """Write the links whose body is near an inner corner to `cor`; return the count."""
    count = 0
    thickness = world[HALF_THICKNESS]
    compliance = world[CONTACT_COMPLIANCE] / (world[DT] * world[DT])
    for k in range(walls.shape[0]):
        if walls[k, W_CORNER] == 0.0:
            continue
        x = walls[k, W_X] + walls[k, W_LENGTH] * walls[k, W_TX]
        y = walls[k, W_Y] + walls[k, W_LENGTH] * walls[k, W_TY]
        for m in range(n - 1):
            cx = x - pos[m, 0]
            cy = y - pos[m, 1]
            reach = body[m, LINK_LENGTH] + thickness
            if abs(cx) > reach or abs(cy) > reach or count == cor.shape[0]:
                continue
            ex = pos[m + 1, 0] - pos[m, 0]
            ey = pos[m + 1, 1] - pos[m, 1]
            length2 = ex * ex + ey * ey
            share = (cx * ex + cy * ey) / length2
            if share <= 0.0 or share >= 1.0:
                continue
            length = np.sqrt(length2)
            if ex * walls[k, W_BY] < ey * walls[k, W_BX]:
                length = -length
            nx = -ey / length
            ny = ex / length
            gap = -(cx * nx + cy * ny) - thickness
            if gap > MARGIN_M * world[LOOK] or gap < -2.0 * thickness:
                continue
            who[count] = m
            cor[count, K_NX] = nx
            cor[count, K_NY] = ny
            cor[count, K_SHARE] = share
            cor[count, K_GAP] = gap
            cor[count, K_PUSH] = 0.0
            mass_inv = body[m, MASS_INV] * (1.0 - share) ** 2 + body[m + 1, MASS_INV] * share**2
            cor[count, K_INV] = 1.0 / (mass_inv + compliance)
            count += 1
    return count


@compiled
def clear(c: int, m: int, pos: Floats, w: Floats, cor: Floats) -> float:
    """Return the gap between a link and an inner corner after what they have moved."""
    ahead = 1.0 - cor[c, K_SHARE]
    behind = cor[c, K_SHARE]
    gap = cor[c, K_GAP]
    gap += cor[c, K_NX] * ahead * (pos[m, 0] - w[m, X0])
    gap += cor[c, K_NY] * ahead * (pos[m, 1] - w[m, Y0])
    gap += cor[c, K_NX] * behind * (pos[m + 1, 0] - w[m + 1, X0])
    gap += cor[c, K_NY] * behind * (pos[m + 1, 1] - w[m + 1, Y0])
    return float(gap)


@compiled
def solve_corners(
    count: int, pos: Floats, body: Floats, compliance: float, w: Floats, cor: Floats, who: Ints
) -> None:
    """Push each link near an inner corner clear of it once."""
    for c in range(count):
        m = who[c]
        ahead = 1.0 - cor[c, K_SHARE]
        behind = cor[c, K_SHARE]
        gap = clear(c, m, pos, w, cor)
        new = max(0.0, cor[c, K_PUSH] - (gap + compliance * cor[c, K_PUSH]) * cor[c, K_INV])
        delta = new - cor[c, K_PUSH]
        cor[c, K_PUSH] = new
        pos[m, 0] += body[m, MASS_INV] * ahead * delta * cor[c, K_NX]
        pos[m, 1] += body[m, MASS_INV] * ahead * delta * cor[c, K_NY]
        pos[m + 1, 0] += body[m + 1, MASS_INV] * behind * delta * cor[c, K_NX]
        pos[m + 1, 1] += body[m + 1, MASS_INV] * behind * delta * cor[c, K_NY]
