"""Contacts of wheels with walls, edges and an obstacle, and of links with edges and elbows."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.kinematic.contacts import at_most
from pirate_sm.simulation.kinematic.space import columns as col
from pirate_sm.simulation.kinematic.space.walls import faces_edge, foot, on_edge
from pirate_sm.simulation.machine_code import compiled

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
    con[count, col.NX] = hit[0]
    con[count, col.NY] = hit[1]
    con[count, col.NZ] = hit[2]
    con[count, col.DISTANCE] = hit[3] - world[col.RADIUS]
    who[count, col.NODE] = i
    who[count, col.SURFACE] = surface
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
    radius = world[col.RADIUS]
    kept = (world[col.LOOK] - 1.0) * world[col.DT]
    for i in range(n):
        x, y, z = pos[i, 0], pos[i, 1], pos[i, 2]
        speed = abs(vel[i, 0]) + abs(vel[i, 1]) + abs(vel[i, 2])
        reach = radius + col.MARGIN_M + kept * speed
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
        if world[col.BLOCK_NODE] == i:
            hit[0] = world[col.BLOCK_NX]
            hit[1] = world[col.BLOCK_NY]
            hit[2] = world[col.BLOCK_NZ]
            hit[3] = (
                (x - world[col.BLOCK_X]) * hit[0]
                + (y - world[col.BLOCK_Y]) * hit[1]
                + (z - world[col.BLOCK_Z]) * hit[2]
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
    nx = con[c, col.NX]
    ny = con[c, col.NY]
    nz = con[c, col.NZ]
    ax = parts[p, col.N_X]
    ay = parts[p, col.N_Y]
    az = parts[p, col.N_Z]
    bx = parts[p, col.N_BX]
    by = parts[p, col.N_BY]
    bz = parts[p, col.N_BZ]
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
    con[c, col.GI_X] = tx
    con[c, col.GI_Y] = ty
    con[c, col.GI_Z] = tz
    con[c, col.SX] = sx
    con[c, col.SY] = sy
    con[c, col.SZ] = sz
    con[c, col.S_TURN] = turn * radius
    return float(sine)


@compiled
def recall(
    c: int, i: int, body: Floats, world: Floats, anchor: Floats, con: Floats, who: Ints
) -> None:
    """Set the targets of a contact to what its wheel has kept there, and its friction."""
    drive = 0.0
    side = 0.0
    for k in range(0, 3 * col.ANCHORS, 3):
        if anchor[i, k] == who[c, col.SURFACE] + 1.0:
            drive = anchor[i, k + 1]
            side = anchor[i, k + 2]
    slipped = col.SLIPPED * world[col.ANCHOR_MAX]
    slipping = drive * drive + side * side >= slipped * slipped
    con[c, col.K_MU] = body[i, col.MU_KINETIC] if slipping else body[i, col.MU_STATIC]
    con[c, col.HELD] = drive
    con[c, col.TARGET] = drive
    con[c, col.S_TARGET] = side


@compiled
def _gear(c: int, i: int, sine: float, body: Floats, world: Floats, w: Floats, con: Floats) -> int:
    """Let a contact drive: its lever, its motor's limits; return the other wheel of the lever.

    The motor reacts on its link: rolling = t dp - r sine (d link angle + d wheel angle).
    """
    radius = world[col.RADIUS] * sine
    link = int(body[i, col.MOTOR_LINK])
    other = link
    column = col.LR_X
    lever = -radius
    if link == i:
        other = link + 1
        column = col.LF_X
        lever = radius
    own = 0.0
    across = 0.0
    for k in range(3):
        reaction = lever * w[link, column + k]
        con[c, col.GI_X + k] -= reaction
        con[c, col.GO_X + k] = reaction
        own += con[c, col.GI_X + k] ** 2
        across += reaction * reaction
    con[c, col.K_RADIUS] = radius
    con[c, col.K_FORCE] = w[i, col.FORCE] / sine
    con[c, col.K_SLOPE] = w[i, col.SLOPE] * sine * sine
    con[c, col.TARGET] += w[i, col.SPIN] * radius
    mass_inv = body[i, col.MASS_INV] * own + body[other, col.MASS_INV] * across
    con[c, col.DRIVE_INV] = 1.0 / (mass_inv + con[c, col.K_SLOPE])
    con[c, col.K_STIFF] = 1.0 / mass_inv
    return other


@compiled
def press(c: int, con: Floats) -> None:
    """Set the gap of a contact by its distance, and zero its impulses."""
    con[c, col.PUSH] = 0.0
    con[c, col.DRIVE] = 0.0
    con[c, col.SIDE] = 0.0
    # The gap as one of constant stiffness would be with the same force.
    gap = con[c, col.DISTANCE]
    gap += (_FLAT_TYRE_STIFFER - 1.0) * min(0.0, gap + _FLAT_TYRE_M)
    con[c, col.GAP] = max(gap, -_DEEPEST_M)


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
    compliance = world[col.CONTACT_COMPLIANCE] / (world[col.DT] * world[col.DT])
    for c in range(count):
        i = who[c, col.NODE]
        p = 0 if i <= world[col.ROLL_LINK] else 1
        who[c, col.PART] = p
        who[c, col.OTHER] = i
        press(c, con)
        con[c, col.PUSH_INV] = 1.0 / (body[i, col.MASS_INV] + compliance)
        if who[c, col.SURFACE] < 0:
            con[c, col.K_MU] = 0.0
            continue
        sine = _face(c, p, world[col.RADIUS], parts, con)
        recall(c, i, body, world, anchor, con, who)
        con[c, col.SIDE_W] = body[i, col.MASS_INV] + con[c, col.S_TURN] ** 2 * parts[p, col.N_INV_I]
        con[c, col.K_CREEP] = _SLIDING_SLIP_RAD
        if sine > 0.0:
            rolls = max(sine, world[col.TYRE_EDGE])
            who[c, col.OTHER] = _gear(c, i, rolls, body, world, w, con)
            continue
        con[c, col.K_CREEP] = 0.0
        con[c, col.K_RADIUS] = 0.0
        con[c, col.K_SLOPE] = 0.0
        con[c, col.K_FORCE] = np.inf
        con[c, col.DRIVE_INV] = con[c, col.K_STIFF] = 1.0 / body[i, col.MASS_INV]
        for k in range(3):
            con[c, col.GO_X + k] = 0.0


@compiled
def solve_contacts(
    count: int,
    mov: Floats,
    body: Floats,
    world: Floats,
    compliance: float,
    parts: Floats,
    con: Floats,
    who: Ints,
) -> None:
    """Push out, roll and hold each contact once, with friction within its cone."""
    for c in range(count):
        i = who[c, col.NODE]
        inv = body[i, col.MASS_INV]
        # What a wheel moves stays in registers until it is known.
        x, y, z = mov[i, 0], mov[i, 1], mov[i, 2]
        push = con[c, col.PUSH]
        gap = (con[c, col.GAP] + con[c, col.NX] * x) + (con[c, col.NY] * y + con[c, col.NZ] * z)
        new = max(0.0, push - (gap + compliance * push) * con[c, col.PUSH_INV])
        step = inv * (new - push)
        con[c, col.PUSH] = new
        x += step * con[c, col.NX]
        y += step * con[c, col.NY]
        z += step * con[c, col.NZ]
        limit = con[c, col.K_MU] * new
        drive = con[c, col.DRIVE]
        side = con[c, col.SIDE]
        if con[c, col.K_MU] == 0.0 or (limit == 0.0 and drive == 0.0 and side == 0.0):
            mov[i, 0] = x
            mov[i, 1] = y
            mov[i, 2] = z
            continue
        o = who[c, col.OTHER]
        p = who[c, col.PART]
        rolled = con[c, col.GI_X] * x + con[c, col.GI_Y] * y + con[c, col.GI_Z] * z
        rolled += (
            con[c, col.GO_X] * mov[o, 0]
            + con[c, col.GO_Y] * mov[o, 1]
            + con[c, col.GO_Z] * mov[o, 2]
        )
        slid = con[c, col.SX] * x + con[c, col.SY] * y + con[c, col.SZ] * z
        slid += con[c, col.S_TURN] * parts[p, col.N_ROLL]
        left = con[c, col.TARGET] - rolled - con[c, col.K_SLOPE] * drive
        drag = world[col.ROLLING_RESISTANCE] * new
        more = left * con[c, col.DRIVE_INV]
        still = (con[c, col.HELD] - rolled) * con[c, col.K_STIFF]
        more += at_most(still - more, con[c, col.K_SLOPE] * con[c, col.DRIVE_INV] * drag)
        to_drive = at_most(drive + more, con[c, col.K_FORCE] + drag)
        creep = con[c, col.K_CREEP] * abs(rolled)
        # At a limit of 0 the circle below leaves nothing.
        to_side = side
        if limit > 0.0:
            away = (con[c, col.S_TARGET] - slid) * limit - creep * side
            to_side += away / (con[c, col.SIDE_W] * limit + creep)
        both2 = to_drive * to_drive + to_side * to_side
        if both2 > limit * limit:
            share = limit / np.sqrt(both2)
            to_drive *= share
            to_side *= share
        con[c, col.DRIVE] = to_drive
        con[c, col.SIDE] = to_side
        drive = to_drive - drive
        side = to_side - side
        mov[i, 0] = x + inv * (drive * con[c, col.GI_X] + side * con[c, col.SX])
        mov[i, 1] = y + inv * (drive * con[c, col.GI_Y] + side * con[c, col.SY])
        mov[i, 2] = z + inv * (drive * con[c, col.GI_Z] + side * con[c, col.SZ])
        parts[p, col.N_ROLL] += parts[p, col.N_INV_I] * con[c, col.S_TURN] * side
        step = body[o, col.MASS_INV] * drive
        mov[o, 0] += step * con[c, col.GO_X]
        mov[o, 1] += step * con[c, col.GO_Y]
        mov[o, 2] += step * con[c, col.GO_Z]


# --- links ---------------------------------------------------------------------------------------


@compiled
def _lean(
    count: int,
    m: int,
    share: float,
    hit: Floats,
    body: Floats,
    world: Floats,
    cor: Floats,
    who: Ints,
) -> int:
    """Note a contact of a link; return the count. `hit`: the normal, the distance of its middle."""
    gap = hit[3] - world[col.HALF_THICKNESS]
    if (
        gap > col.MARGIN_M * world[col.LOOK]
        or gap < -2.0 * world[col.HALF_THICKNESS]
        or count == cor.shape[0]
    ):
        return count
    compliance = world[col.CONTACT_COMPLIANCE] / (world[col.DT] * world[col.DT])
    who[count] = m
    cor[count, col.K_NX] = hit[0]
    cor[count, col.K_NY] = hit[1]
    cor[count, col.K_NZ] = hit[2]
    cor[count, col.K_SHARE] = share
    cor[count, col.K_GAP] = gap
    cor[count, col.K_PUSH] = 0.0
    mass_inv = body[m, col.MASS_INV] * (1.0 - share) ** 2 + body[m + 1, col.MASS_INV] * share**2
    cor[count, col.K_INV] = 1.0 / (mass_inv + compliance)
    return count + 1


@compiled
def _share(pos: Floats, m: int, x: float, y: float, z: float) -> float:
    """Return where on a link is the place nearest to a point: 0 its front end, 1 its rear end."""
    ex = pos[m + 1, 0] - pos[m, 0]
    ey = pos[m + 1, 1] - pos[m, 1]
    ez = pos[m + 1, 2] - pos[m, 2]
    along = (x - pos[m, 0]) * ex + (y - pos[m, 1]) * ey + (z - pos[m, 2]) * ez
    return float(along / (ex * ex + ey * ey + ez * ez))


@compiled
def _lean_on_edge(
    count: int,
    m: int,
    pos: Floats,
    edge: Floats,
    points: Floats,
    at: int,
    body: Floats,
    world: Floats,
    cor: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Note the contact of a link with an edge, if any; return the count."""
    share = _share(pos, m, points[at, col.P_X], points[at, col.P_Y], points[at, col.P_Z])
    for _ in range(2):
        share = min(max(share, 0.0), 1.0)
        x = pos[m, 0] + share * (pos[m + 1, 0] - pos[m, 0])
        y = pos[m, 1] + share * (pos[m + 1, 1] - pos[m, 1])
        z = pos[m, 2] + share * (pos[m + 1, 2] - pos[m, 2])
        at = on_edge(x, y, z, edge, points, at, hit)
        share = _share(pos, m, hit[0], hit[1], hit[2])
    if share <= 0.0 or share >= 1.0:
        return count
    x = pos[m, 0] + share * (pos[m + 1, 0] - pos[m, 0]) - hit[0]
    y = pos[m, 1] + share * (pos[m + 1, 1] - pos[m, 1]) - hit[1]
    z = pos[m, 2] + share * (pos[m + 1, 2] - pos[m, 2]) - hit[2]
    away = np.sqrt(x * x + y * y + z * z)
    if away > world[col.HALF_THICKNESS] + col.MARGIN_M * world[col.LOOK] or away < 1e-9:
        return count
    # The link may have got over the edge with its middle; the pipe's inside says which way is out.
    if x * points[at, col.P_IX] + y * points[at, col.P_IY] + z * points[at, col.P_IZ] < 0.0:
        away = -away
    hit[0] = x / away
    hit[1] = y / away
    hit[2] = z / away
    hit[3] = away
    return int(_lean(count, m, share, hit, body, world, cor, who))


@compiled
def find_leaning(
    n: int,
    pos: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
    body: Floats,
    world: Floats,
    near: Ints,
    nears: Ints,
    rims: Ints,
    link_at: Ints,
    cor: Floats,
    who: Ints,
    hit: Floats,
) -> int:
    """Write the links that touch an edge or the inner side of an elbow; return the count."""
    count = 0
    for m in range(n - 1):
        if rims[m] != 0:
            for k in range(edges.shape[0]):
                at = link_at[m, k]
                if at >= 0:
                    count = _lean_on_edge(
                        count, m, pos, edges[k], points, at, body, world, cor, who, hit
                    )
        for k in range(nears[m]):
            solid = near[m, k]
            if solids[solid, col.KIND] != col.TORUS:
                continue
            # The place of the link that is nearest to the axis of the ring.
            ax = solids[solid, col.A_X]
            ay = solids[solid, col.A_Y]
            az = solids[solid, col.A_Z]
            dx = pos[m, 0] - solids[solid, col.O_X]
            dy = pos[m, 1] - solids[solid, col.O_Y]
            dz = pos[m, 2] - solids[solid, col.O_Z]
            ex = pos[m + 1, 0] - pos[m, 0]
            ey = pos[m + 1, 1] - pos[m, 1]
            ez = pos[m + 1, 2] - pos[m, 2]
            de = dx * ex + dy * ey + dz * ez
            da = dx * ax + dy * ay + dz * az
            ea = ex * ax + ey * ay + ez * az
            length2 = ex * ex + ey * ey + ez * ez - ea * ea
            if length2 < 1e-9:
                continue
            share = -(de - da * ea) / length2
            if share <= 0.0 or share >= 1.0:
                continue
            x = pos[m, 0] + share * ex
            y = pos[m, 1] + share * ey
            z = pos[m, 2] + share * ez
            if foot(x, y, z, solids, solid, hit):
                count = _lean(count, m, share, hit, body, world, cor, who)
    return count


@compiled
def clear(c: int, m: int, mov: Floats, cor: Floats) -> float:
    """Return the gap between a link and what it leans on after what it has moved."""
    behind = cor[c, col.K_SHARE]
    ahead = 1.0 - behind
    gap = cor[c, col.K_GAP]
    gap += cor[c, col.K_NX] * ahead * mov[m, 0]
    gap += cor[c, col.K_NY] * ahead * mov[m, 1]
    gap += cor[c, col.K_NZ] * ahead * mov[m, 2]
    gap += cor[c, col.K_NX] * behind * mov[m + 1, 0]
    gap += cor[c, col.K_NY] * behind * mov[m + 1, 1]
    gap += cor[c, col.K_NZ] * behind * mov[m + 1, 2]
    return float(gap)


@compiled
def solve_leaning(
    count: int, mov: Floats, body: Floats, compliance: float, w: Floats, cor: Floats, who: Ints
) -> None:
    """Push each link that leans on something clear of it once."""
    for c in range(count):
        m = who[c]
        behind = cor[c, col.K_SHARE]
        ahead = 1.0 - behind
        gap = clear(c, m, mov, cor)
        new = max(
            0.0, cor[c, col.K_PUSH] - (gap + compliance * cor[c, col.K_PUSH]) * cor[c, col.K_INV]
        )
        delta = new - cor[c, col.K_PUSH]
        cor[c, col.K_PUSH] = new
        step = body[m, col.MASS_INV] * ahead * delta
        mov[m, 0] += step * cor[c, col.K_NX]
        mov[m, 1] += step * cor[c, col.K_NY]
        mov[m, 2] += step * cor[c, col.K_NZ]
        step = body[m + 1, col.MASS_INV] * behind * delta
        mov[m + 1, 0] += step * cor[c, col.K_NX]
        mov[m + 1, 1] += step * cor[c, col.K_NY]
        mov[m + 1, 2] += step * cor[c, col.K_NZ]
