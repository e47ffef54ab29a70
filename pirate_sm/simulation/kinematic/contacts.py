"""Contacts of wheels with walls and an obstacle, and of links with inner corners of the pipe."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.kinematic import columns as col
from pirate_sm.simulation.machine_code import compiled


@compiled
def _wall_contact(
    x: float, y: float, wall: Floats, reach: float, depth: float, hit: Floats
) -> bool:
    """Return whether a point is near a wall; write the normal there and the distance to `hit`."""
    dx = x - wall[col.W_X]
    dy = y - wall[col.W_Y]
    along = dx * wall[col.W_TX] + dy * wall[col.W_TY]
    if along < 0.0:
        return False
    if along <= wall[col.W_LENGTH]:
        hit[0] = wall[col.W_NX]
        hit[1] = wall[col.W_NY]
        hit[2] = dx * hit[0] + dy * hit[1]
        return bool(-depth < hit[2] < reach)
    if wall[col.W_CORNER] == 0.0:
        return False
    dx -= wall[col.W_LENGTH] * wall[col.W_TX]
    dy -= wall[col.W_LENGTH] * wall[col.W_TY]
    if dx * wall[col.W_NEXT_TX] + dy * wall[col.W_NEXT_TY] >= 0.0:
        return False
    away2 = dx * dx + dy * dy
    if away2 >= reach * reach or away2 == 0.0:
        return False
    hit[2] = np.sqrt(away2)
    hit[0] = dx / hit[2]
    hit[1] = dy / hit[2]
    return True


@compiled
def find_contacts(
    n: int,
    pos: Floats,
    vel: Floats,
    walls: Floats,
    world: Floats,
    con: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Write normals and gaps of wheels near a wall or an obstacle to `con`; return the count."""
    count = 0
    kept = (world[col.LOOK] - 1.0) * world[col.DT]
    for i in range(n):
        x = pos[i, 0]
        y = pos[i, 1]
        reach = world[col.RADIUS] + col.MARGIN_M + kept * (abs(vel[i, 0]) + abs(vel[i, 1]))
        for k in range(walls.shape[0] + 1):
            if k < walls.shape[0]:
                near = _wall_contact(x, y, walls[k], reach, world[col.DEPTH], hit)
            elif world[col.BLOCK_NODE] == i:
                hit[0] = world[col.BLOCK_NX]
                hit[1] = world[col.BLOCK_NY]
                hit[2] = (x - world[col.BLOCK_X]) * hit[0] + (y - world[col.BLOCK_Y]) * hit[1]
                near = hit[2] < reach
            else:
                near = False
            if near and count < con.shape[0]:
                con[count, col.NX] = hit[0]
                con[count, col.NY] = hit[1]
                con[count, col.GAP] = hit[2] - world[col.RADIUS]
                who[count, col.NODE] = i
                # Two walls of one side meet in a corner, where a wheel may touch both.
                who[count, col.KEY] = k % 4 if k < walls.shape[0] else -1
                count += 1
    return count


@compiled
def aim(
    c: int, i: int, body: Floats, world: Floats, anchor: Floats, w: Floats, con: Floats, who: Ints
) -> None:
    """Zero the impulses of a contact, and set its target and friction to what its wheel kept."""
    con[c, col.PUSH] = 0.0
    con[c, col.ROLLING] = 0.0
    if who[c, col.KEY] < 0:
        con[c, col.C_MU] = 0.0
        return
    held = anchor[i, who[c, col.KEY]]
    slipping = abs(held) >= col.SLIPPED * world[col.ANCHOR_MAX]
    con[c, col.C_MU] = body[i, col.MU_KINETIC] if slipping else body[i, col.MU_STATIC]
    con[c, col.HELD] = held
    con[c, col.TARGET] = w[i, col.SPIN] * world[col.RADIUS] + held


@compiled
def prepare_contacts(
    count: int, body: Floats, world: Floats, anchor: Floats, w: Floats, con: Floats, who: Ints
) -> None:
    """Set gradients, masses, limits and targets of the contacts, and zero their impulses.

    The wheel's motor reacts on its link: rolling = t dp - r (d link angle + d wheel angle).
    """
    radius = world[col.RADIUS]
    compliance = world[col.CONTACT_COMPLIANCE] / (world[col.DT] * world[col.DT])
    for c in range(count):
        i = who[c, col.NODE]
        link = int(body[i, col.MOTOR_LINK])
        hx = radius * w[link, col.LEVER_X]
        hy = radius * w[link, col.LEVER_Y]
        other = link
        if link == i:
            other = link + 1
        else:
            hx = -hx
            hy = -hy
        who[c, col.OTHER] = other
        con[c, col.GI_X] = -con[c, col.NY] - hx
        con[c, col.GI_Y] = con[c, col.NX] - hy
        con[c, col.GO_X] = hx
        con[c, col.GO_Y] = hy
        con[c, col.N_INV] = 1.0 / (body[i, col.MASS_INV] + compliance)
        aim(c, i, body, world, anchor, w, con, who)
        if who[c, col.KEY] < 0:
            continue
        con[c, col.C_FORCE] = w[i, col.FORCE]
        con[c, col.C_SLOPE] = w[i, col.SLOPE]
        mass_inv = body[i, col.MASS_INV] * (con[c, col.GI_X] ** 2 + con[c, col.GI_Y] ** 2)
        mass_inv += body[other, col.MASS_INV] * (hx * hx + hy * hy)
        con[c, col.T_INV] = 1.0 / (mass_inv + w[i, col.SLOPE])
        con[c, col.C_STIFF] = 1.0 / mass_inv


@compiled
def rolled_m(c: int, i: int, o: int, pos: Floats, w: Floats, con: Floats) -> float:
    """Return how far a wheel without its motor would have rolled along the wall."""
    return float(
        con[c, col.GI_X] * (pos[i, 0] - w[i, col.X0])
        + con[c, col.GI_Y] * (pos[i, 1] - w[i, col.Y0])
        + con[c, col.GO_X] * (pos[o, 0] - w[o, col.X0])
        + con[c, col.GO_Y] * (pos[o, 1] - w[o, col.Y0])
    )


@compiled
def at_most(value: float, most: float) -> float:
    """Return a value, or the nearest one whose size is this at most: what dry friction takes."""
    return min(max(value, -most), most)


@compiled
def solve_contacts(
    count: int,
    pos: Floats,
    body: Floats,
    world: Floats,
    compliance: float,
    w: Floats,
    con: Floats,
    who: Ints,
) -> None:
    """Push out and roll each contact once, with friction within its cone.

    A tyre resists rolling as dry friction of the axle would: it takes from the force of the motor
    what is left to roll with, and no more than its share of the normal force.
    """
    for c in range(count):
        i = who[c, col.NODE]
        inv = body[i, col.MASS_INV]
        gap = con[c, col.GAP] + con[c, col.NX] * (pos[i, 0] - w[i, col.X0])
        gap += con[c, col.NY] * (pos[i, 1] - w[i, col.Y0])
        new = max(0.0, con[c, col.PUSH] - (gap + compliance * con[c, col.PUSH]) * con[c, col.N_INV])
        step = inv * (new - con[c, col.PUSH])
        con[c, col.PUSH] = new
        pos[i, 0] += step * con[c, col.NX]
        pos[i, 1] += step * con[c, col.NY]
        drag = world[col.ROLLING_RESISTANCE] * new
        limit = min(con[c, col.C_MU] * new, con[c, col.C_FORCE] + drag)
        old = con[c, col.ROLLING]
        if con[c, col.C_MU] == 0.0 or (limit == 0.0 and old == 0.0):
            continue
        o = who[c, col.OTHER]
        rolled = rolled_m(c, i, o, pos, w, con)
        left = con[c, col.TARGET] - rolled - con[c, col.C_SLOPE] * old
        more = left * con[c, col.T_INV]
        still = (con[c, col.HELD] - rolled) * con[c, col.C_STIFF]
        more += at_most(still - more, con[c, col.C_SLOPE] * con[c, col.T_INV] * drag)
        new = at_most(old + more, limit)
        con[c, col.ROLLING] = new
        step = inv * (new - old)
        pos[i, 0] += step * con[c, col.GI_X]
        pos[i, 1] += step * con[c, col.GI_Y]
        step = body[o, col.MASS_INV] * (new - old)
        pos[o, 0] += step * con[c, col.GO_X]
        pos[o, 1] += step * con[c, col.GO_Y]


# --- corners -------------------------------------------------------------------------------------


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
