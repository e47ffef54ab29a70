"""Contacts of wheels with walls, edges and an obstacle: how they push, roll and slide."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.space.columns import (
    ANCHOR_MAX,
    ANCHORS,
    BLOCK_NODE,
    BLOCK_NX,
    BLOCK_NY,
    BLOCK_NZ,
    BLOCK_X,
    BLOCK_Y,
    BLOCK_Z,
    CONTACT_COMPLIANCE,
    DISTANCE,
    DRIVE,
    DRIVE_INV,
    DT,
    FORCE,
    GAP,
    GI_X,
    GI_Y,
    GI_Z,
    GO_X,
    GO_Y,
    GO_Z,
    K_CREEP,
    K_FORCE,
    K_MU,
    K_RADIUS,
    K_SLOPE,
    LF_X,
    LOOK,
    LR_X,
    MARGIN_M,
    MASS_INV,
    MOTOR_LINK,
    MU_KINETIC,
    MU_STATIC,
    N_BX,
    N_BY,
    N_BZ,
    N_INV_I,
    N_ROLL,
    N_X,
    N_Y,
    N_Z,
    NODE,
    NX,
    NY,
    NZ,
    OTHER,
    PART,
    PUSH,
    PUSH_INV,
    RADIUS,
    ROLL_LINK,
    S_TARGET,
    S_TURN,
    SIDE,
    SIDE_W,
    SLIPPED,
    SLOPE,
    SPIN,
    SURFACE,
    SX,
    SY,
    SZ,
    TARGET,
)
from pirate_sm.simulation.xpbd.space.walls import faces_edge, foot, on_edge

# Below this share of its radius a wheel that lies on its side does not roll.
_LEAST_ROLLING = 0.05
# Slip angle at which a rolling wheel slides sideways; below, it creeps in proportion to the force
# (brush model of a tyre: Pacejka, Tire and Vehicle Dynamics, chapter 3) [assumed].
_SLIDING_SLIP_RAD = 0.1
# Deeper than the first, as on the edge of a step, a tyre is so many times as stiff [assumed]. The
# last is pushed out in a substep at most, lest a wheel that comes over a rim is thrown [by trial].
_FLAT_TYRE_M, _FLAT_TYRE_STIFFER, _DEEPEST_M = 0.0018, 4.0, 0.006


@compiled
def _touch(
    count: int, i: int, surface: int, hit: Floats, world: Floats, con: Floats, who: Ints
) -> int:
    """Note a contact of a wheel; return the count of contacts."""
    if count == con.shape[0]:
        return count
    con[count, NX] = hit[0]
    con[count, NY] = hit[1]
    con[count, NZ] = hit[2]
    con[count, DISTANCE] = hit[3] - world[RADIUS]
    who[count, NODE] = i
    who[count, SURFACE] = surface
    return count + 1


@compiled
def find_contacts(
    n: int,
    pos: Floats,
    vel: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
    world: Floats,
    near: Ints,
    nears: Ints,
    rims: Ints,
    rim_at: Ints,
    con: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Write normals and gaps of wheels near a wall, an edge or an obstacle; return the count."""
    count = 0
    radius = world[RADIUS]
    kept = (world[LOOK] - 1.0) * world[DT]
    for i in range(n):
        x, y, z = pos[i, 0], pos[i, 1], pos[i, 2]
        speed = abs(vel[i, 0]) + abs(vel[i, 1]) + abs(vel[i, 2])
        reach = radius + MARGIN_M + kept * speed
        for k in range(nears[i]):
            solid = near[i, k]
            if foot(x, y, z, solids, solid, hit) and -radius < hit[3] < reach:
                count = _touch(count, i, solid, hit, world, con, who)
        if rims[i] != 0:
            for k in range(edges.shape[0]):
                if rim_at[i, k] < 0:
                    continue
                at = on_edge(x, y, z, edges[k], points, rim_at[i, k], hit)
                rim_at[i, k] = at
                if faces_edge(x, y, z, solids, edges[k], reach, hit):
                    count = _touch(count, i, solids.shape[0] + k, hit, world, con, who)
        if world[BLOCK_NODE] == i:
            hit[0] = world[BLOCK_NX]
            hit[1] = world[BLOCK_NY]
            hit[2] = world[BLOCK_NZ]
            hit[3] = (
                (x - world[BLOCK_X]) * hit[0]
                + (y - world[BLOCK_Y]) * hit[1]
                + (z - world[BLOCK_Z]) * hit[2]
            )
            if hit[3] < reach:
                count = _touch(count, i, -1, hit, world, con, who)
    return count


@compiled
def _face(c: int, p: int, radius: float, parts: Floats, con: Floats) -> float:
    """Write the directions of driving and sliding of a contact; return the sine axle to normal.

    Sliding = s dp + r s (e x N) d roll, with e = b x n. A wheel that lies on its side does not
    roll, and any direction in the wall will do: then the sine is 0.
    """
    nx = con[c, NX]
    ny = con[c, NY]
    nz = con[c, NZ]
    ax = parts[p, N_X]
    ay = parts[p, N_Y]
    az = parts[p, N_Z]
    bx = parts[p, N_BX]
    by = parts[p, N_BY]
    bz = parts[p, N_BZ]
    ex = by * az - bz * ay
    ey = bz * ax - bx * az
    ez = bx * ay - by * ax
    tx = ay * nz - az * ny
    ty = az * nx - ax * nz
    tz = ax * ny - ay * nx
    sine = np.sqrt(tx * tx + ty * ty + tz * tz)
    length = sine
    if sine < _LEAST_ROLLING:
        tx = by * nz - bz * ny
        ty = bz * nx - bx * nz
        tz = bx * ny - by * nx
        length = np.sqrt(tx * tx + ty * ty + tz * tz)
        sine = 0.0
    share = 1.0 / length
    tx *= share
    ty *= share
    tz *= share
    sx = ny * tz - nz * ty
    sy = nz * tx - nx * tz
    sz = nx * ty - ny * tx
    turn = sx * (ey * nz - ez * ny) + sy * (ez * nx - ex * nz) + sz * (ex * ny - ey * nx)
    con[c, GI_X] = tx
    con[c, GI_Y] = ty
    con[c, GI_Z] = tz
    con[c, SX] = sx
    con[c, SY] = sy
    con[c, SZ] = sz
    con[c, S_TURN] = turn * radius
    return float(sine)


@compiled
def recall(
    c: int, i: int, body: Floats, world: Floats, anchor: Floats, con: Floats, who: Ints
) -> None:
    """Set the targets of a contact to what its wheel has kept there, and its friction."""
    drive = 0.0
    side = 0.0
    for k in range(0, 3 * ANCHORS, 3):
        if anchor[i, k] == who[c, SURFACE] + 1.0:
            drive = anchor[i, k + 1]
            side = anchor[i, k + 2]
    slipped = SLIPPED * world[ANCHOR_MAX]
    slipping = drive * drive + side * side >= slipped * slipped
    con[c, K_MU] = body[i, MU_KINETIC] if slipping else body[i, MU_STATIC]
    con[c, TARGET] = drive
    con[c, S_TARGET] = side


@compiled
def _gear(c: int, i: int, sine: float, body: Floats, world: Floats, w: Floats, con: Floats) -> int:
    """Let a contact drive: its lever, its motor's limits; return the other wheel of the lever.

    The motor reacts on its link: rolling = t dp - r sine (d link angle + d wheel angle).
    """
    radius = world[RADIUS] * sine
    link = int(body[i, MOTOR_LINK])
    other = link
    column = LR_X
    lever = -radius
    if link == i:
        other = link + 1
        column = LF_X
        lever = radius
    own = 0.0
    across = 0.0
    for k in range(3):
        reaction = lever * w[link, column + k]
        con[c, GI_X + k] -= reaction
        con[c, GO_X + k] = reaction
        own += con[c, GI_X + k] ** 2
        across += reaction * reaction
    con[c, K_RADIUS] = radius
    con[c, K_FORCE] = w[i, FORCE] / sine
    con[c, K_SLOPE] = w[i, SLOPE] * sine * sine
    con[c, TARGET] += w[i, SPIN] * radius
    mass_inv = body[i, MASS_INV] * own + body[other, MASS_INV] * across
    con[c, DRIVE_INV] = 1.0 / (mass_inv + con[c, K_SLOPE])
    return other


@compiled
def press(c: int, con: Floats) -> None:
    """Set the gap of a contact by its distance, and zero its impulses."""
    con[c, PUSH] = 0.0
    con[c, DRIVE] = 0.0
    con[c, SIDE] = 0.0
    # The gap as one of constant stiffness would be with the same force.
    gap = con[c, DISTANCE]
    gap += (_FLAT_TYRE_STIFFER - 1.0) * min(0.0, gap + _FLAT_TYRE_M)
    con[c, GAP] = max(gap, -_DEEPEST_M)


@compiled
def prepare_contacts(
    count: int,
    body: Floats,
    world: Floats,
    anchor: Floats,
    w: Floats,
    parts: Floats,
    con: Floats,
    who: Ints,
) -> None:
    """Set gradients, masses, limits and targets of the contacts, and zero their impulses."""
    compliance = world[CONTACT_COMPLIANCE] / (world[DT] * world[DT])
    for c in range(count):
        i = who[c, NODE]
        p = 0 if i <= world[ROLL_LINK] else 1
        who[c, PART] = p
        who[c, OTHER] = i
        press(c, con)
        con[c, PUSH_INV] = 1.0 / (body[i, MASS_INV] + compliance)
        if who[c, SURFACE] < 0:
            con[c, K_MU] = 0.0
            continue
        sine = _face(c, p, world[RADIUS], parts, con)
        recall(c, i, body, world, anchor, con, who)
        con[c, SIDE_W] = body[i, MASS_INV] + con[c, S_TURN] ** 2 * parts[p, N_INV_I]
        con[c, K_CREEP] = _SLIDING_SLIP_RAD
        if sine > 0.0:
            who[c, OTHER] = _gear(c, i, sine, body, world, w, con)
            continue
        con[c, K_CREEP] = 0.0
        con[c, K_RADIUS] = 0.0
        con[c, K_SLOPE] = 0.0
        con[c, K_FORCE] = np.inf
        con[c, DRIVE_INV] = 1.0 / body[i, MASS_INV]
        for k in range(3):
            con[c, GO_X + k] = 0.0


@compiled
def solve_contacts(
    count: int, mov: Floats, body: Floats, compliance: float, parts: Floats, con: Floats, who: Ints
) -> None:
    """Push out, roll and hold each contact once, with friction within its cone."""
    for c in range(count):
        i = who[c, NODE]
        inv = body[i, MASS_INV]
        # What a wheel moves stays in registers until it is known.
        x, y, z = mov[i, 0], mov[i, 1], mov[i, 2]
        push = con[c, PUSH]
        gap = (con[c, GAP] + con[c, NX] * x) + (con[c, NY] * y + con[c, NZ] * z)
        new = max(0.0, push - (gap + compliance * push) * con[c, PUSH_INV])
        step = inv * (new - push)
        con[c, PUSH] = new
        x += step * con[c, NX]
        y += step * con[c, NY]
        z += step * con[c, NZ]
        limit = con[c, K_MU] * new
        drive = con[c, DRIVE]
        side = con[c, SIDE]
        if con[c, K_MU] == 0.0 or (limit == 0.0 and drive == 0.0 and side == 0.0):
            mov[i, 0] = x
            mov[i, 1] = y
            mov[i, 2] = z
            continue
        o = who[c, OTHER]
        p = who[c, PART]
        rolled = con[c, GI_X] * x + con[c, GI_Y] * y + con[c, GI_Z] * z
        rolled += con[c, GO_X] * mov[o, 0] + con[c, GO_Y] * mov[o, 1] + con[c, GO_Z] * mov[o, 2]
        slid = con[c, SX] * x + con[c, SY] * y + con[c, SZ] * z
        slid += con[c, S_TURN] * parts[p, N_ROLL]
        left = con[c, TARGET] - rolled - con[c, K_SLOPE] * drive
        to_drive = drive + left * con[c, DRIVE_INV]
        to_drive = min(max(to_drive, -con[c, K_FORCE]), con[c, K_FORCE])
        creep = con[c, K_CREEP] * abs(rolled)
        # At a limit of 0 the circle below leaves nothing.
        to_side = side
        if limit > 0.0:
            away = (con[c, S_TARGET] - slid) * limit - creep * side
            to_side += away / (con[c, SIDE_W] * limit + creep)
        both2 = to_drive * to_drive + to_side * to_side
        if both2 > limit * limit:
            share = limit / np.sqrt(both2)
            to_drive *= share
            to_side *= share
        con[c, DRIVE] = to_drive
        con[c, SIDE] = to_side
        drive = to_drive - drive
        side = to_side - side
        mov[i, 0] = x + inv * (drive * con[c, GI_X] + side * con[c, SX])
        mov[i, 1] = y + inv * (drive * con[c, GI_Y] + side * con[c, SY])
        mov[i, 2] = z + inv * (drive * con[c, GI_Z] + side * con[c, SZ])
        parts[p, N_ROLL] += parts[p, N_INV_I] * con[c, S_TURN] * side
        step = body[o, MASS_INV] * drive
        mov[o, 0] += step * con[c, GO_X]
        mov[o, 1] += step * con[c, GO_Y]
        mov[o, 2] += step * con[c, GO_Z]
