"""Contacts of wheels with walls and an obstacle: where they are, how they push and roll."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.columns import (
    ANCHOR_MAX,
    BLOCK_NODE,
    BLOCK_NX,
    BLOCK_NY,
    BLOCK_X,
    BLOCK_Y,
    C_FORCE,
    C_MU,
    C_SLOPE,
    CONTACT_COMPLIANCE,
    DEPTH,
    DT,
    FORCE,
    GAP,
    GI_X,
    GI_Y,
    GO_X,
    GO_Y,
    KEY,
    LEVER_X,
    LEVER_Y,
    LOOK,
    MARGIN_M,
    MASS_INV,
    MOTOR_LINK,
    MU_KINETIC,
    MU_STATIC,
    N_INV,
    NODE,
    NX,
    NY,
    OTHER,
    PUSH,
    RADIUS,
    ROLLING,
    SLIPPED,
    SLOPE,
    SPIN,
    T_INV,
    TARGET,
    W_CORNER,
    W_LENGTH,
    W_NEXT_TX,
    W_NEXT_TY,
    W_NX,
    W_NY,
    W_TX,
    W_TY,
    W_X,
    W_Y,
    X0,
    Y0,
)


@compiled
def _wall_contact(
    x: float, y: float, wall: Floats, reach: float, depth: float, hit: Floats
) -> bool:
    """Return whether a point is near a wall; write the normal there and the distance to `hit`."""
    dx = x - wall[W_X]
    dy = y - wall[W_Y]
    along = dx * wall[W_TX] + dy * wall[W_TY]
    if along < 0.0:
        return False
    if along <= wall[W_LENGTH]:
        hit[0] = wall[W_NX]
        hit[1] = wall[W_NY]
        hit[2] = dx * hit[0] + dy * hit[1]
        return bool(-depth < hit[2] < reach)
    if wall[W_CORNER] == 0.0:
        return False
    dx -= wall[W_LENGTH] * wall[W_TX]
    dy -= wall[W_LENGTH] * wall[W_TY]
    if dx * wall[W_NEXT_TX] + dy * wall[W_NEXT_TY] >= 0.0:
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
    kept = (world[LOOK] - 1.0) * world[DT]
    for i in range(n):
        x = pos[i, 0]
        y = pos[i, 1]
        reach = world[RADIUS] + MARGIN_M + kept * (abs(vel[i, 0]) + abs(vel[i, 1]))
        for k in range(walls.shape[0] + 1):
            if k < walls.shape[0]:
                near = _wall_contact(x, y, walls[k], reach, world[DEPTH], hit)
            elif world[BLOCK_NODE] == i:
                hit[0] = world[BLOCK_NX]
                hit[1] = world[BLOCK_NY]
                hit[2] = (x - world[BLOCK_X]) * hit[0] + (y - world[BLOCK_Y]) * hit[1]
                near = hit[2] < reach
            else:
                near = False
            if near and count < con.shape[0]:
                con[count, NX] = hit[0]
                con[count, NY] = hit[1]
                con[count, GAP] = hit[2] - world[RADIUS]
                who[count, NODE] = i
                # Two walls of one side meet in a corner, where a wheel may touch both.
                who[count, KEY] = k % 4 if k < walls.shape[0] else -1
                count += 1
    return count


@compiled
def aim(
    c: int, i: int, body: Floats, world: Floats, anchor: Floats, w: Floats, con: Floats, who: Ints
) -> None:
    """Zero the impulses of a contact, and set its target and friction to what its wheel kept."""
    con[c, PUSH] = 0.0
    con[c, ROLLING] = 0.0
    if who[c, KEY] < 0:
        con[c, C_MU] = 0.0
        return
    held = anchor[i, who[c, KEY]]
    slipping = abs(held) >= SLIPPED * world[ANCHOR_MAX]
    con[c, C_MU] = body[i, MU_KINETIC] if slipping else body[i, MU_STATIC]
    con[c, TARGET] = w[i, SPIN] * world[RADIUS] + held


@compiled
def prepare_contacts(
    count: int, body: Floats, world: Floats, anchor: Floats, w: Floats, con: Floats, who: Ints
) -> None:
    """Set gradients, masses, limits and targets of the contacts, and zero their impulses.

    The wheel's motor reacts on its link: rolling = t dp - r (d link angle + d wheel angle).
    """
    radius = world[RADIUS]
    compliance = world[CONTACT_COMPLIANCE] / (world[DT] * world[DT])
    for c in range(count):
        i = who[c, NODE]
        link = int(body[i, MOTOR_LINK])
        hx = radius * w[link, LEVER_X]
        hy = radius * w[link, LEVER_Y]
        other = link
        if link == i:
            other = link + 1
        else:
            hx = -hx
            hy = -hy
        who[c, OTHER] = other
        con[c, GI_X] = -con[c, NY] - hx
        con[c, GI_Y] = con[c, NX] - hy
        con[c, GO_X] = hx
        con[c, GO_Y] = hy
        con[c, N_INV] = 1.0 / (body[i, MASS_INV] + compliance)
        aim(c, i, body, world, anchor, w, con, who)
        if who[c, KEY] < 0:
            continue
        con[c, C_FORCE] = w[i, FORCE]
        con[c, C_SLOPE] = w[i, SLOPE]
        mass_inv = body[i, MASS_INV] * (con[c, GI_X] ** 2 + con[c, GI_Y] ** 2)
        mass_inv += body[other, MASS_INV] * (hx * hx + hy * hy)
        con[c, T_INV] = 1.0 / (mass_inv + w[i, SLOPE])


@compiled
def rolled_m(c: int, i: int, o: int, pos: Floats, w: Floats, con: Floats) -> float:
    """Return how far a wheel without its motor would have rolled along the wall."""
    return float(
        con[c, GI_X] * (pos[i, 0] - w[i, X0])
        + con[c, GI_Y] * (pos[i, 1] - w[i, Y0])
        + con[c, GO_X] * (pos[o, 0] - w[o, X0])
        + con[c, GO_Y] * (pos[o, 1] - w[o, Y0])
    )


@compiled
def solve_contacts(
    count: int, pos: Floats, body: Floats, compliance: float, w: Floats, con: Floats, who: Ints
) -> None:
    """Push out and roll each contact once, with friction within its cone."""
    for c in range(count):
        i = who[c, NODE]
        inv = body[i, MASS_INV]
        gap = con[c, GAP] + con[c, NX] * (pos[i, 0] - w[i, X0])
        gap += con[c, NY] * (pos[i, 1] - w[i, Y0])
        new = max(0.0, con[c, PUSH] - (gap + compliance * con[c, PUSH]) * con[c, N_INV])
        step = inv * (new - con[c, PUSH])
        con[c, PUSH] = new
        pos[i, 0] += step * con[c, NX]
        pos[i, 1] += step * con[c, NY]
        limit = min(con[c, C_MU] * new, con[c, C_FORCE])
        old = con[c, ROLLING]
        if con[c, C_MU] == 0.0 or (limit == 0.0 and old == 0.0):
            continue
        o = who[c, OTHER]
        left = con[c, TARGET] - rolled_m(c, i, o, pos, w, con) - con[c, C_SLOPE] * old
        new = min(max(old + left * con[c, T_INV], -limit), limit)
        con[c, ROLLING] = new
        step = inv * (new - old)
        pos[i, 0] += step * con[c, GI_X]
        pos[i, 1] += step * con[c, GI_Y]
        step = body[o, MASS_INV] * (new - old)
        pos[o, 0] += step * con[c, GO_X]
        pos[o, 1] += step * con[c, GO_Y]
