"""Contacts of links with inner corners of the pipe."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd import columns as col


@compiled
def find_corners(
    n: int, pos: Floats, walls: Floats, body: Floats, world: Floats, cor: Floats, who: Ints
) -> int:
    """Write the links whose body is near an inner corner to `cor`; return the count."""
    count = 0
    thickness = world[col.HALF_THICKNESS]
    compliance = world[col.CONTACT_COMPLIANCE] / (world[col.DT] * world[col.DT])
    for k in range(walls.shape[0]):
        if walls[k, col.W_CORNER] == 0.0:
            continue
        x = walls[k, col.W_X] + walls[k, col.W_LENGTH] * walls[k, col.W_TX]
        y = walls[k, col.W_Y] + walls[k, col.W_LENGTH] * walls[k, col.W_TY]
        for m in range(n - 1):
            cx = x - pos[m, 0]
            cy = y - pos[m, 1]
            reach = body[m, col.LINK_LENGTH] + thickness
            if abs(cx) > reach or abs(cy) > reach or count == cor.shape[0]:
                continue
            ex = pos[m + 1, 0] - pos[m, 0]
            ey = pos[m + 1, 1] - pos[m, 1]
            length2 = ex * ex + ey * ey
            share = (cx * ex + cy * ey) / length2
            if share <= 0.0 or share >= 1.0:
                continue
            length = np.sqrt(length2)
            if ex * walls[k, col.W_BY] < ey * walls[k, col.W_BX]:
                length = -length
            nx = -ey / length
            ny = ex / length
            gap = -(cx * nx + cy * ny) - thickness
            if gap > col.MARGIN_M * world[col.LOOK] or gap < -2.0 * thickness:
                continue
            who[count] = m
            cor[count, col.K_NX] = nx
            cor[count, col.K_NY] = ny
            cor[count, col.K_SHARE] = share
            cor[count, col.K_GAP] = gap
            cor[count, col.K_PUSH] = 0.0
            mass_inv = (
                body[m, col.MASS_INV] * (1.0 - share) ** 2 + body[m + 1, col.MASS_INV] * share**2
            )
            cor[count, col.K_INV] = 1.0 / (mass_inv + compliance)
            count += 1
    return count


@compiled
def clear(c: int, m: int, pos: Floats, w: Floats, cor: Floats) -> float:
    """Return the gap between a link and an inner corner after what they have moved."""
    ahead = 1.0 - cor[c, col.K_SHARE]
    behind = cor[c, col.K_SHARE]
    gap = cor[c, col.K_GAP]
    gap += cor[c, col.K_NX] * ahead * (pos[m, 0] - w[m, col.X0])
    gap += cor[c, col.K_NY] * ahead * (pos[m, 1] - w[m, col.Y0])
    gap += cor[c, col.K_NX] * behind * (pos[m + 1, 0] - w[m + 1, col.X0])
    gap += cor[c, col.K_NY] * behind * (pos[m + 1, 1] - w[m + 1, col.Y0])
    return float(gap)


@compiled
def solve_corners(
    count: int, pos: Floats, body: Floats, compliance: float, w: Floats, cor: Floats, who: Ints
) -> None:
    """Push each link near an inner corner clear of it once."""
    for c in range(count):
        m = who[c]
        ahead = 1.0 - cor[c, col.K_SHARE]
        behind = cor[c, col.K_SHARE]
        gap = clear(c, m, pos, w, cor)
        new = max(
            0.0, cor[c, col.K_PUSH] - (gap + compliance * cor[c, col.K_PUSH]) * cor[c, col.K_INV]
        )
        delta = new - cor[c, col.K_PUSH]
        cor[c, col.K_PUSH] = new
        pos[m, 0] += body[m, col.MASS_INV] * ahead * delta * cor[c, col.K_NX]
        pos[m, 1] += body[m, col.MASS_INV] * ahead * delta * cor[c, col.K_NY]
        pos[m + 1, 0] += body[m + 1, col.MASS_INV] * behind * delta * cor[c, col.K_NX]
        pos[m + 1, 1] += body[m + 1, col.MASS_INV] * behind * delta * cor[c, col.K_NY]
