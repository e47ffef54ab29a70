"""The compiled part of the kinematic simulator: extended position-based dynamics in a plane.

Python calls :func:`advance` alone; its machine code is built with the package
(`simulation/machine_code`). `chain.py`, `world.py` and `pipe_arrays.py` fill the arrays whose
columns are named here.

A substep is: motors, predict, iterate (joints, contacts, corners, links), velocity from
displacement (XPBD, Macklin et al. 2016). Gradients are those at the start of the substep, since
nothing turns by more than a few mrad in one; a coarser computation keeps them, and what touches
what, for some substeps. Impulses are in kg m, that is force times the squared step.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled

# Columns of `body`, a row per wheel; joint columns are of the joint at that wheel, the link's
# length is of the link from that wheel to the next one behind it.
MASS_INV, MU_STATIC, MU_KINETIC, WHEEL_RATE, WHEEL_STALL, WHEEL_HOLD, MOTOR_LINK = range(7)
JOINT_K, JOINT_RATE, JOINT_STALL, JOINT_FRICTION, JOINT_MIN, JOINT_MAX, JOINT_DAMPING = range(7, 14)
LINK_LENGTH = 14
BODY_COLUMNS = 15

# Columns of `walls`: start, unit tangent, length, unit normal into the pipe; whether an inner
# corner ends it, then the next wall's tangent and the bisector into the pipe.
W_X, W_Y, W_TX, W_TY, W_LENGTH, W_NX, W_NY, W_CORNER, W_NEXT_TX, W_NEXT_TY, W_BX, W_BY = range(12)
WALL_COLUMNS = 12

# Columns of `legs`, the straight parts of the centre line: start, unit tangent, length, arc length
# at the start, gravity along it, towards side A and along the normal of the plane.
L_X, L_Y, L_TX, L_TY, L_LENGTH, L_S, L_GT, L_GN, L_GB = range(9)
LEG_COLUMNS = 9

# Entries of `world`: the step, the body's sizes, the contact, an obstacle, the roll joint, the
# magnetic field in the axes of the drawing; for how many substeps directions and contacts are kept,
# and in which iteration joints are first pulled.
DT, ITERATIONS, RADIUS, HALF_THICKNESS, CONTACT_COMPLIANCE, ANCHOR_MAX, DEPTH = range(7)
BLOCK_NODE, BLOCK_X, BLOCK_Y, BLOCK_NX, BLOCK_NY = range(7, 12)
ROLL_LINK, ROLL_TARGET, ROLL_RATE, MAG_X, MAG_Y, MAG_Z, ROLL_STALL = range(12, 19)
LOOK, PULL = 19, 20
WORLD_ENTRIES = 21

# Blocks of `state`; the number times the count of wheels is the length of each.
S_POSITION, S_VELOCITY, S_MOTOR, S_WHEEL, S_BEND, S_ANCHOR, S_TURNED, S_READ, S_ROLL = (
    0, 2, 4, 5, 6, 7, 11, 12, 13,
)  # fmt: skip
# `out` has a block for each of `physics.PER_WHEEL`, the entries `physics.SINGLE`, and two blocks of
# the kernel's own: each wheel's offset towards side A and the number of its leg.
OUT_PER_WHEEL = 9
OUT_SINGLE = 8
OUT_OWN = 2

# Scratch columns per wheel.
(
    X0, Y0, LEVER_X, LEVER_Y, GA_X, GA_Y, GM_X, GM_Y, GB_X, GB_Y, J_C, J_D, J_W, J_INV, J_LAM,
    J_FRICTION, J_STOP, G_X, G_Y, SPIN, FORCE, SLOPE, LINK_SCALE,
    J_RESISTS, DRAG,
) = range(25)  # fmt: skip
_NODE_COLUMNS = 25
# Sums per wheel over the substeps of a call.
T_PRESS, T_DRIVE, T_GRIP, T_TORQUE, T_CURRENT, _T_COLUMNS = range(6)
# Scratch columns per contact, and per link at an inner corner.
(
    NX, NY, GAP, PUSH, GI_X, GI_Y, GO_X, GO_Y, N_INV, T_INV, ROLLING, TARGET, C_SLOPE, C_MU,
    C_FORCE,
) = range(15)  # fmt: skip
_CONTACT_COLUMNS = 15
K_NX, K_NY, K_SHARE, K_GAP, K_PUSH, K_INV, _K_COLUMNS = range(7)
NODE, OTHER, KEY = range(3)

_CONTACTS_EACH = 3
_CORNERS = 4
# Blocks of `scratch`; the number times the count of wheels is where each begins. After the last one
# stand the contacts at corners and a foot. A call begins with zeros in the sums.
_AT_NODES = 0
_AT_TALLY = _AT_NODES + _NODE_COLUMNS
_AT_CONTACTS = _AT_TALLY + _T_COLUMNS
_AT_CORNERS = _AT_CONTACTS + _CONTACTS_EACH * _CONTACT_COLUMNS
_FOOT = 3
# Blocks of `marks`, likewise: who touches, and the strongest contact; then which links touch.
_AT_TOUCH = 3 * _CONTACTS_EACH
_AT_WHO_CORNERS = _AT_TOUCH + 1

_MARGIN_M = 0.002
_WHEEL_FILTER = 0.5  # of x_velocity, a mean of angle differences (thesis B-11)
# The motor side of a spring may wind this far beyond the joint's own end stop.
_WINDING_RAD = 0.6
# Share of its limit from which a force counts as having reached it.
_REACHED = 0.9999
# Shares of the longest anchor: from the first on the friction is kinetic; a wheel that does not
# slip stays below the second.
_SLIPPED, _STUCK = 0.999, 0.998
# A part that lies in the pipe presses with up to its weight, and little more where its joints still
# bear some torque. A part that was clamped and is relaxed presses with at least 4 weights.
_LYING_WEIGHTS = 2.0
# A joint farther from its end stops than this cannot reach them in one substep.
_STOP_RAD = 0.1


def scratch_arrays(wheels: int) -> tuple[Floats, Ints]:
    """Return arrays for `scratch` and `marks` of :func:`advance`, which keeps nothing in them."""
    return (
        np.zeros(_AT_CORNERS * wheels + _CORNERS * _K_COLUMNS + _FOOT),
        np.zeros(_AT_WHO_CORNERS * wheels + _CORNERS, dtype=np.int64),
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
def _find_contacts(
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
        reach = world[RADIUS] + _MARGIN_M + kept * (abs(vel[i, 0]) + abs(vel[i, 1]))
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
def _aim(
    c: int, i: int, body: Floats, world: Floats, anchor: Floats, w: Floats, con: Floats, who: Ints
) -> None:
    """Zero the impulses of a contact, and set its target and friction to what its wheel kept."""
    con[c, PUSH] = 0.0
    con[c, ROLLING] = 0.0
    if who[c, KEY] < 0:
        con[c, C_MU] = 0.0
        return
    held = anchor[i, who[c, KEY]]
    slipping = abs(held) >= _SLIPPED * world[ANCHOR_MAX]
    con[c, C_MU] = body[i, MU_KINETIC] if slipping else body[i, MU_STATIC]
    con[c, TARGET] = w[i, SPIN] * world[RADIUS] + held


@compiled
def _prepare_contacts(
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
        _aim(c, i, body, world, anchor, w, con, who)
        if who[c, KEY] < 0:
            continue
        con[c, C_FORCE] = w[i, FORCE]
        con[c, C_SLOPE] = w[i, SLOPE]
        mass_inv = body[i, MASS_INV] * (con[c, GI_X] ** 2 + con[c, GI_Y] ** 2)
        mass_inv += body[other, MASS_INV] * (hx * hx + hy * hy)
        con[c, T_INV] = 1.0 / (mass_inv + w[i, SLOPE])


@compiled
def _rolled(c: int, i: int, o: int, pos: Floats, w: Floats, con: Floats) -> float:
    """Return how far a wheel without its motor would have rolled along the wall."""
    return float(
        con[c, GI_X] * (pos[i, 0] - w[i, X0])
        + con[c, GI_Y] * (pos[i, 1] - w[i, Y0])
        + con[c, GO_X] * (pos[o, 0] - w[o, X0])
        + con[c, GO_Y] * (pos[o, 1] - w[o, Y0])
    )


@compiled
def _solve_contacts(
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
        left = con[c, TARGET] - _rolled(c, i, o, pos, w, con) - con[c, C_SLOPE] * old
        new = min(max(old + left * con[c, T_INV], -limit), limit)
        con[c, ROLLING] = new
        step = inv * (new - old)
        pos[i, 0] += step * con[c, GI_X]
        pos[i, 1] += step * con[c, GI_Y]
        step = body[o, MASS_INV] * (new - old)
        pos[o, 0] += step * con[c, GO_X]
        pos[o, 1] += step * con[c, GO_Y]


@compiled
def _find_corners(
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
            if gap > _MARGIN_M * world[LOOK] or gap < -2.0 * thickness:
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
def _clear(c: int, m: int, pos: Floats, w: Floats, cor: Floats) -> float:
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
def _solve_corners(
    count: int, pos: Floats, body: Floats, compliance: float, w: Floats, cor: Floats, who: Ints
) -> None:
    """Push each link near an inner corner clear of it once."""
    for c in range(count):
        m = who[c]
        ahead = 1.0 - cor[c, K_SHARE]
        behind = cor[c, K_SHARE]
        gap = _clear(c, m, pos, w, cor)
        new = max(0.0, cor[c, K_PUSH] - (gap + compliance * cor[c, K_PUSH]) * cor[c, K_INV])
        delta = new - cor[c, K_PUSH]
        cor[c, K_PUSH] = new
        pos[m, 0] += body[m, MASS_INV] * ahead * delta * cor[c, K_NX]
        pos[m, 1] += body[m, MASS_INV] * ahead * delta * cor[c, K_NY]
        pos[m + 1, 0] += body[m + 1, MASS_INV] * behind * delta * cor[c, K_NX]
        pos[m + 1, 1] += body[m + 1, MASS_INV] * behind * delta * cor[c, K_NY]


@compiled
def _turned(i: int, pos: Floats, w: Floats) -> float:
    """Return by how much a joint has turned in this substep."""
    # Three short sums, because one long sum would wait for each of its terms in turn.
    ahead = w[i, GA_X] * (pos[i - 1, 0] - w[i - 1, X0])
    ahead += w[i, GA_Y] * (pos[i - 1, 1] - w[i - 1, Y0])
    middle = w[i, GM_X] * (pos[i, 0] - w[i, X0]) + w[i, GM_Y] * (pos[i, 1] - w[i, Y0])
    behind = w[i, GB_X] * (pos[i + 1, 0] - w[i + 1, X0])
    behind += w[i, GB_Y] * (pos[i + 1, 1] - w[i + 1, Y0])
    return float(behind + middle + ahead)


@compiled
def _turn_motor(
    i: int,
    duty: float,
    bend: Floats,
    motor: Floats,
    body: Floats,
    dt: float,
    w: Floats,
    tally: Floats,
) -> None:
    """Turn the motor of a joint by one substep, and zero the joint's impulses.

    It turns at rate * (duty - torque / stall torque) and is never driven back.
    """
    rate = duty - body[i, JOINT_K] * (motor[i] - bend[i]) / body[i, JOINT_STALL]
    rate = min(max(rate, min(duty, 0.0)), max(duty, 0.0))
    turned = motor[i] + body[i, JOINT_RATE] * rate * dt
    motor[i] = min(
        max(turned, body[i, JOINT_MIN] - _WINDING_RAD), body[i, JOINT_MAX] + _WINDING_RAD
    )
    tally[i, T_CURRENT] += abs(duty - rate)
    w[i, J_LAM] = 0.0
    w[i, J_FRICTION] = 0.0
    w[i, J_STOP] = 0.0


@compiled
def _go_on(
    n: int,
    count: int,
    corners: int,
    pos: Floats,
    bend: Floats,
    motor: Floats,
    anchor: Floats,
    command: Floats,
    body: Floats,
    world: Floats,
    w: Floats,
    con: Floats,
    who: Ints,
    cor: Floats,
    at_corner: Ints,
    tally: Floats,
) -> None:
    """Begin a substep with the directions and contacts of the one before.

    Angles and gaps change by what the wheels have moved along these directions.
    """
    for i in range(1, n - 1):
        bend[i] += _turned(i, pos, w)
        _turn_motor(i, command[i], bend, motor, body, world[DT], w, tally)
    for c in range(count):
        i = who[c, NODE]
        con[c, GAP] += con[c, NX] * (pos[i, 0] - w[i, X0]) + con[c, NY] * (pos[i, 1] - w[i, Y0])
        _aim(c, i, body, world, anchor, w, con, who)
    for c in range(corners):
        cor[c, K_GAP] = _clear(c, at_corner[c], pos, w, cor)
        cor[c, K_PUSH] = 0.0
    for i in range(n):
        w[i, X0] = pos[i, 0]
        w[i, Y0] = pos[i, 1]


@compiled
def _begin(
    n: int,
    pos: Floats,
    bend: Floats,
    motor: Floats,
    command: Floats,
    body: Floats,
    world: Floats,
    w: Floats,
    tally: Floats,
) -> None:
    """Compute angles and gradients from the positions, and turn the motors by one substep."""
    dt = world[DT]
    before = 0.0
    for i in range(n):
        w[i, X0] = pos[i, 0]
        w[i, Y0] = pos[i, 1]
        if i == n - 1:
            break
        ex = pos[i, 0] - pos[i + 1, 0]
        ey = pos[i, 1] - pos[i + 1, 1]
        length2 = ex * ex + ey * ey
        w[i, LEVER_X] = -ey / length2
        w[i, LEVER_Y] = ex / length2
        heading = np.arctan2(ey, ex)
        change = heading - before - bend[i]
        before = heading
        if i == 0:
            continue
        if abs(change) > np.pi:
            change -= 2.0 * np.pi * np.rint(change / (2.0 * np.pi))
        bend[i] += change
        _turn_motor(i, command[i], bend, motor, body, dt, w, tally)
        w[i, GA_X] = -w[i - 1, LEVER_X]
        w[i, GA_Y] = -w[i - 1, LEVER_Y]
        w[i, GB_X] = -w[i, LEVER_X]
        w[i, GB_Y] = -w[i, LEVER_Y]
        w[i, GM_X] = w[i, LEVER_X] + w[i - 1, LEVER_X]
        w[i, GM_Y] = w[i, LEVER_Y] + w[i - 1, LEVER_Y]
        w[i, J_W] = (
            body[i - 1, MASS_INV] * (w[i, GA_X] ** 2 + w[i, GA_Y] ** 2)
            + body[i, MASS_INV] * (w[i, GM_X] ** 2 + w[i, GM_Y] ** 2)
            + body[i + 1, MASS_INV] * (w[i, GB_X] ** 2 + w[i, GB_Y] ** 2)
        )
        w[i, J_INV] = 1.0 / ((1.0 + w[i, J_D]) * w[i, J_W] + w[i, J_C])
        free = body[i, JOINT_MIN] + _STOP_RAD < bend[i] < body[i, JOINT_MAX] - _STOP_RAD
        w[i, J_RESISTS] = 0.0 if free and body[i, JOINT_FRICTION] == 0.0 else 1.0


@compiled
def _predict(n: int, pos: Floats, vel: Floats, dt: float, w: Floats) -> None:
    """Move the wheels as gravity and the floor's friction alone would."""
    for i in range(n):
        vx = vel[i, 0] + dt * w[i, G_X]
        vy = vel[i, 1] + dt * w[i, G_Y]
        if w[i, DRAG] > 0.0:
            speed = np.sqrt(vx * vx + vy * vy)
            left = 1.0 - w[i, DRAG] / speed if speed > w[i, DRAG] else 0.0
            vx *= left
            vy *= left
        pos[i, 0] += dt * vx
        pos[i, 1] += dt * vy


@compiled
def _resist(i: int, turned: float, bend: float, body: Floats, dt2: float, w: Floats) -> float:
    """Return the impulse that a joint's dry friction and end stops add after it has turned."""
    added = 0.0
    if body[i, JOINT_FRICTION] > 0.0:
        limit = body[i, JOINT_FRICTION] * dt2
        new = min(max(w[i, J_FRICTION] - turned / w[i, J_W], -limit), limit)
        added = new - w[i, J_FRICTION]
        w[i, J_FRICTION] = new
    angle = bend + turned + added * w[i, J_W]
    old = w[i, J_STOP]
    if angle > body[i, JOINT_MAX] or old < 0.0:
        w[i, J_STOP] = min(0.0, old - (angle - body[i, JOINT_MAX]) / w[i, J_W])
    elif angle < body[i, JOINT_MIN] or old > 0.0:
        w[i, J_STOP] = max(0.0, old - (angle - body[i, JOINT_MIN]) / w[i, J_W])
    return float(added + w[i, J_STOP] - old)


@compiled
def _solve_joints(
    n: int, pos: Floats, bend: Floats, motor: Floats, body: Floats, dt2: float, w: Floats
) -> None:
    """Pull each joint once towards its motor-side angle through its spring."""
    for i in range(1, n - 1):
        turned = _turned(i, pos, w)
        left = motor[i] - bend[i] - turned * (1.0 + w[i, J_D]) - w[i, J_C] * w[i, J_LAM]
        delta = left * w[i, J_INV]
        w[i, J_LAM] += delta
        turned += w[i, J_W] * delta
        if w[i, J_RESISTS] != 0.0:
            delta += _resist(i, turned, bend[i], body, dt2, w)
        step = body[i - 1, MASS_INV] * delta
        pos[i - 1, 0] += step * w[i, GA_X]
        pos[i - 1, 1] += step * w[i, GA_Y]
        step = body[i, MASS_INV] * delta
        pos[i, 0] += step * w[i, GM_X]
        pos[i, 1] += step * w[i, GM_Y]
        step = body[i + 1, MASS_INV] * delta
        pos[i + 1, 0] += step * w[i, GB_X]
        pos[i + 1, 1] += step * w[i, GB_Y]


@compiled
def _solve_links(n: int, pos: Floats, body: Floats, w: Floats) -> None:
    """Bring each link back to its length once."""
    for m in range(n - 1):
        dx = pos[m, 0] - pos[m + 1, 0]
        dy = pos[m, 1] - pos[m + 1, 1]
        # (d^2 - l^2) / 2l has the same root as d - l and needs no square root.
        scale = (body[m, LINK_LENGTH] ** 2 - dx * dx - dy * dy) * w[m, LINK_SCALE]
        ahead = scale * body[m, MASS_INV]
        behind = scale * body[m + 1, MASS_INV]
        pos[m, 0] += ahead * dx
        pos[m, 1] += ahead * dy
        pos[m + 1, 0] -= behind * dx
        pos[m + 1, 1] -= behind * dy


@compiled
def _strongest(n: int, count: int, con: Floats, who: Ints, touch: Ints, tally: Floats) -> None:
    """Write the strongest wall contact of each wheel to `touch`, -1 without any."""
    for i in range(n):
        touch[i] = -1
    for c in range(count):
        i = who[c, NODE]
        if con[c, PUSH] > 0.0 and who[c, KEY] >= 0:
            tally[i, T_PRESS] += con[c, PUSH]
            if touch[i] < 0 or con[c, PUSH] > con[touch[i], PUSH]:
                touch[i] = c


@compiled
def _turn_wheels(
    n: int,
    count: int,
    pos: Floats,
    wheel: Floats,
    anchor: Floats,
    world: Floats,
    w: Floats,
    con: Floats,
    who: Ints,
    touch: Ints,
    tally: Floats,
) -> None:
    """Turn the wheels, and carry unsolved rolling over as the anchor.

    Without the anchor a hold creeps and the driven distance is wrong by percents. A wheel slips,
    and turns with its motor, only if the force along the wall has reached its friction. A blocked
    wheel may leave much unsolved although it grips. All other wheels turn with the wall.
    """
    radius = world[RADIUS]
    bound = world[ANCHOR_MAX]
    _strongest(n, count, con, who, touch, tally)
    anchor[:] = 0.0
    for c in range(count):
        if con[c, PUSH] <= 0.0 or who[c, KEY] < 0:
            continue
        i = who[c, NODE]
        rolled = _rolled(c, i, who[c, OTHER], pos, w, con)
        force = con[c, ROLLING]
        left = con[c, TARGET] - rolled - con[c, C_SLOPE] * force
        tally[i, T_DRIVE] += abs(force)
        tally[i, T_GRIP] += force
        friction = con[c, C_MU] * con[c, PUSH]
        stalled = con[c, C_FORCE] < friction and abs(force) >= _REACHED * con[c, C_FORCE]
        slips = abs(left) >= bound and not stalled and abs(force) >= _REACHED * friction
        if not stalled:
            most = bound if slips else _STUCK * bound
            anchor[i, who[c, KEY]] = min(max(left, -most), most)
        if touch[i] == c:
            wheel[i] += w[i, SPIN] - con[c, C_SLOPE] * force / radius if slips else rolled / radius
    for i in range(n):
        if touch[i] < 0:
            wheel[i] += w[i, SPIN]


@compiled
def _project(n: int, pos: Floats, legs: Floats, out: Floats) -> None:
    """Write arc length, offset towards side A and leg of each wheel to their blocks of `out`."""
    side = OUT_PER_WHEEL * n + OUT_SINGLE
    for i in range(n):
        best = np.inf
        for k in range(legs.shape[0]):
            dx = pos[i, 0] - legs[k, L_X]
            dy = pos[i, 1] - legs[k, L_Y]
            along = dx * legs[k, L_TX] + dy * legs[k, L_TY]
            across = dy * legs[k, L_TX] - dx * legs[k, L_TY]
            # The first and the last leg continue beyond the pipe's open ends.
            if k > 0:
                along = max(along, 0.0)
            if k < legs.shape[0] - 1:
                along = min(along, legs[k, L_LENGTH])
            ax = dx - along * legs[k, L_TX]
            ay = dy - along * legs[k, L_TY]
            away2 = ax * ax + ay * ay
            if away2 < best:
                best = away2
                out[7 * n + i] = legs[k, L_S] + along
                out[side + i] = across
                out[side + n + i] = k


@compiled
def _lies(n: int, part: int, body: Floats, legs: Floats, world: Floats, out: Floats) -> bool:
    """Return whether a part (1: ahead of the roll joint, 2: behind) lies in the pipe, unwedged."""
    press, mass = 0.0, 0.0
    for i in range(n):
        if (i <= world[ROLL_LINK]) == (part == 1):
            press += out[6 * n + i]
            mass += 1.0 / body[i, MASS_INV]
    gravity = np.sqrt(legs[0, L_GT] ** 2 + legs[0, L_GN] ** 2 + legs[0, L_GB] ** 2)
    return bool(press <= _LYING_WEIGHTS * mass * gravity)


@compiled
def _prepare(
    n: int,
    command: Floats,
    body: Floats,
    legs: Floats,
    world: Floats,
    roll: Floats,
    out: Floats,
    w: Floats,
) -> None:
    """Set what is constant during a call: gravity, motor limits, compliances."""
    dt = world[DT]
    radius = world[RADIUS]
    leg_of = (OUT_PER_WHEEL + 1) * n + OUT_SINGLE
    front, rear = roll[1], roll[2]
    if front != rear:
        front_lies = _lies(n, 1, body, legs, world, out)
        rear_lies = _lies(n, 2, body, legs, world, out)
        # The joints of the holding part bear the weight of the other one, in their own plane.
        if front_lies and not rear_lies:
            front = rear
        elif rear_lies and not front_lies:
            rear = front
    for i in range(n):
        leg = legs[int(out[leg_of + i])]
        part = front if i <= world[ROLL_LINK] else rear
        across = leg[L_GN]
        if part != 0.0:
            across = leg[L_GN] * np.cos(part) - leg[L_GB] * np.sin(part)
        w[i, G_X] = leg[L_GT] * leg[L_TX] - across * leg[L_TY]
        w[i, G_Y] = leg[L_GT] * leg[L_TY] + across * leg[L_TX]
        # A wheel that presses on no wall lies on the floor and drags by its weight.
        floor = abs(leg[L_GN] * np.sin(part) + leg[L_GB] * np.cos(part))
        w[i, DRAG] = body[i, MU_KINETIC] * floor * dt if out[6 * n + i] == 0.0 else 0.0
        duty = command[n + i]
        w[i, SPIN] = duty * body[i, WHEEL_RATE] * dt
        w[i, SLOPE] = 0.0
        w[i, FORCE] = body[i, WHEEL_HOLD] / radius * dt * dt
        if duty != 0.0:
            w[i, FORCE] = body[i, WHEEL_STALL] / radius * dt * dt
            w[i, SLOPE] = body[i, WHEEL_RATE] * radius**2 / (body[i, WHEEL_STALL] * dt)
        w[i, J_C] = 1.0 / (body[i, JOINT_K] * dt * dt)
        w[i, J_D] = body[i, JOINT_DAMPING] / (body[i, JOINT_K] * dt)
        if i < n - 1:
            both = body[i, MASS_INV] + body[i + 1, MASS_INV]
            w[i, LINK_SCALE] = 0.5 / (body[i, LINK_LENGTH] ** 2 * both)


@compiled
def _turn_roll(
    n: int, roll: Floats, body: Floats, legs: Floats, world: Floats, passed: float, out: Floats
) -> None:
    """Turn the roll joint towards its target, as far as one of the parts can turn.

    A part that presses on the walls with much more than its own weight is wedged and does not
    turn. A part that only lies there turns against the friction of its wheels, with the pipe's
    radius as lever. If both parts could turn, the one with less friction does.

    The current is the motor's share of its stall torque: all of it while it stalls.
    """
    k = OUT_PER_WHEEL * n
    out[k] = roll[0]
    out[k + 1] = 0.0
    wanted = world[ROLL_TARGET] - roll[0]
    if wanted == 0.0:
        return
    part, friction = 0, np.inf
    for half in (1, 2):
        if not _lies(n, half, body, legs, world, out):
            continue
        torque = 0.0
        for i in range(n):
            if (i <= world[ROLL_LINK]) == (half == 1):
                torque += body[i, MU_STATIC] * out[6 * n + i] * world[DEPTH]
        if torque < friction:
            part, friction = half, torque
    load = friction / world[ROLL_STALL]
    if part == 0 or load >= 1.0:
        out[k + 1] = 1.0
        return
    reach = world[ROLL_RATE] * (1.0 - load) * passed
    turn = min(max(wanted, -reach), reach)
    roll[0] += turn
    roll[part] += turn if part == 1 else -turn
    out[k] = roll[0]
    out[k + 1] = load


@compiled
def _feel(
    n: int,
    pos: Floats,
    accel_x: float,
    accel_y: float,
    legs: Floats,
    world: Floats,
    roll: Floats,
    out: Floats,
    w: Floats,
) -> None:
    """Write the IMU's quantities to `out`: specific force and field along forward, side B, up.

    "Up" is the normal of the plane of the part ahead of the roll joint. It points up when the
    pipe lies flat and the part has roll 0. In free fall the specific force is zero.
    """
    k = OUT_PER_WHEEL * n
    m = min(max(int(world[ROLL_LINK]), 0), n - 2)
    leg = legs[int(out[(OUT_PER_WHEEL + 1) * n + OUT_SINGLE + m])]
    hx = pos[m, 0] - pos[m + 1, 0]
    hy = pos[m, 1] - pos[m + 1, 1]
    length = np.sqrt(hx * hx + hy * hy)
    hx /= length
    hy /= length
    cr = np.cos(roll[1])
    sr = np.sin(roll[1])
    across = leg[L_GN] if roll[1] == 0.0 else leg[L_GN] * cr - leg[L_GB] * sr
    fx = accel_x - (leg[L_GT] * leg[L_TX] - across * leg[L_TY])
    fy = accel_y - (leg[L_GT] * leg[L_TY] + across * leg[L_TX])
    out[k + 2] = fx * hx + fy * hy
    out[k + 3] = fx * hy - fy * hx
    out[k + 4] = leg[L_GN] * sr + leg[L_GB] * cr
    sideways = world[MAG_X] * hy - world[MAG_Y] * hx
    out[k + 5] = world[MAG_X] * hx + world[MAG_Y] * hy
    out[k + 6] = sideways * cr - world[MAG_Z] * sr
    out[k + 7] = sideways * sr + world[MAG_Z] * cr


@compiled
def advance(
    state: Floats,
    command: Floats,
    body: Floats,
    walls: Floats,
    legs: Floats,
    world: Floats,
    out: Floats,
    scratch: Floats,
    marks: Ints,
    steps: int,
) -> None:
    """Simulate `steps` substeps and write the quantities to `out`.

    Equal inputs give equal results to the bit. SI units.

    Args:
        state: See `chain.ChainState`; changed.
        command: Duty of the joint at each wheel, then of each wheel.
        body: `(wheels, BODY_COLUMNS)`.
        walls: `(2 * legs, WALL_COLUMNS)`, side A and side B of each leg in turn.
        legs: `(legs, LEG_COLUMNS)`.
        world: `(WORLD_ENTRIES,)`.
        out: `((OUT_PER_WHEEL + OUT_OWN) * wheels + OUT_SINGLE,)`; it must hold the output of the
            last call.
        scratch: Memory, of :func:`scratch_arrays`, which keeps nothing. Code that gets memory of
            its own counts who uses each array, which took a tenth of the time.
        marks: Memory too.
        steps: Number of substeps; at least 1.
    """
    n = body.shape[0]
    pos = state[: 2 * n].reshape(n, 2)
    vel = state[2 * n : 4 * n].reshape(n, 2)
    motor = state[S_MOTOR * n : S_WHEEL * n]
    wheel = state[S_WHEEL * n : S_BEND * n]
    bend = state[S_BEND * n : S_ANCHOR * n]
    anchor = state[S_ANCHOR * n : S_TURNED * n].reshape(n, 4)
    turned = state[S_TURNED * n : S_READ * n]
    read = state[S_READ * n : S_ROLL * n]
    roll = state[S_ROLL * n : S_ROLL * n + 3]
    w = scratch[: _AT_TALLY * n].reshape(n, _NODE_COLUMNS)
    tally = scratch[_AT_TALLY * n : _AT_CONTACTS * n].reshape(n, _T_COLUMNS)
    con = scratch[_AT_CONTACTS * n : _AT_CORNERS * n].reshape(_CONTACTS_EACH * n, _CONTACT_COLUMNS)
    at = _AT_CORNERS * n + _CORNERS * _K_COLUMNS
    cor = scratch[_AT_CORNERS * n : at].reshape(_CORNERS, _K_COLUMNS)
    hit = scratch[at : at + _FOOT]
    who = marks[: _AT_TOUCH * n].reshape(_CONTACTS_EACH * n, 3)
    touch = marks[_AT_TOUCH * n : _AT_WHO_CORNERS * n]
    at_corner = marks[_AT_WHO_CORNERS * n : _AT_WHO_CORNERS * n + _CORNERS]
    tally[:] = 0.0
    dt = world[DT]
    compliance = world[CONTACT_COMPLIANCE] / (dt * dt)
    imu = min(max(int(world[ROLL_LINK]), 0), n - 2)
    vx = vel[imu, 0]
    vy = vel[imu, 1]
    _project(n, pos, legs, out)
    _prepare(n, command, body, legs, world, roll, out, w)
    count = 0
    corners = 0
    for step in range(steps):
        if step % int(world[LOOK]) == 0:
            _begin(n, pos, bend, motor, command, body, world, w, tally)
            count = _find_contacts(n, pos, vel, walls, world, con, who, hit)
            _prepare_contacts(count, body, world, anchor, w, con, who)
            corners = _find_corners(n, pos, walls, body, world, cor, at_corner)
        else:
            _go_on(
                n, count, corners, pos, bend, motor, anchor, command, body, world, w,
                con, who, cor, at_corner, tally,
            )  # fmt: skip
        _predict(n, pos, vel, dt, w)
        for k in range(int(world[ITERATIONS])):
            if k >= world[PULL]:
                _solve_joints(n, pos, bend, motor, body, dt * dt, w)
            _solve_contacts(count, pos, body, compliance, w, con, who)
            _solve_corners(corners, pos, body, compliance, w, cor, at_corner)
            _solve_links(n, pos, body, w)
        for i in range(n):
            vel[i, 0] = (pos[i, 0] - w[i, X0]) / dt
            vel[i, 1] = (pos[i, 1] - w[i, Y0]) / dt
            tally[i, T_TORQUE] += body[i, JOINT_K] * (motor[i] - bend[i])
        _turn_wheels(n, count, pos, wheel, anchor, world, w, con, who, touch, tally)
    _project(n, pos, legs, out)
    passed = dt * steps
    per_step = 1.0 / (dt * dt * steps)
    for i in range(n):
        turned[i] += _WHEEL_FILTER * (wheel[i] - read[i] - turned[i])
        read[i] = wheel[i]
        out[i] = bend[i]
        out[n + i] = tally[i, T_TORQUE] / steps
        out[2 * n + i] = tally[i, T_CURRENT] / steps
        out[3 * n + i] = wheel[i]
        out[4 * n + i] = turned[i]
        out[5 * n + i] = tally[i, T_DRIVE] * per_step * world[RADIUS]
        out[6 * n + i] = tally[i, T_PRESS] * per_step
        out[8 * n + i] = tally[i, T_GRIP] * per_step
    _turn_roll(n, roll, body, legs, world, passed, out)
    accel_x = (vel[imu, 0] - vx) / passed
    accel_y = (vel[imu, 1] - vy) / passed
    _feel(n, pos, accel_x, accel_y, legs, world, roll, out, w)
