"""Joints between links, the planes of the two parts, the motors of wheels and the roll joint."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.kinematic.contacts import at_most
from pirate_sm.simulation.kinematic.joints_and_motors import REACHED, resist, strongest
from pirate_sm.simulation.kinematic.space import columns as col
from pirate_sm.simulation.machine_code import compiled

# --- joints --------------------------------------------------------------------------------------


@compiled
def turned_rad(i: int, mov: Floats, w: Floats) -> float:
    """Return by how much a joint has turned in this substep."""
    # Three short sums, because one long sum would wait for each of its terms in turn.
    ahead = w[i, col.GA_X] * mov[i - 1, 0]
    ahead += w[i, col.GA_Y] * mov[i - 1, 1]
    ahead += w[i, col.GA_Z] * mov[i - 1, 2]
    middle = w[i, col.GM_X] * mov[i, 0]
    middle += w[i, col.GM_Y] * mov[i, 1]
    middle += w[i, col.GM_Z] * mov[i, 2]
    behind = w[i, col.GB_X] * mov[i + 1, 0]
    behind += w[i, col.GB_Y] * mov[i + 1, 1]
    behind += w[i, col.GB_Z] * mov[i + 1, 2]
    return float(behind + middle + ahead)


@compiled
def solve_joints(
    n: int, mov: Floats, bend: Floats, motor: Floats, body: Floats, dt2: float, w: Floats
) -> None:
    """Pull each joint once towards its motor-side angle through its spring."""
    for i in range(1, n - 1):
        turned = turned_rad(i, mov, w)
        left = motor[i] - bend[i] - turned * (1.0 + w[i, col.J_D]) - w[i, col.J_C] * w[i, col.J_LAM]
        delta = left * w[i, col.J_INV]
        w[i, col.J_LAM] += delta
        turned += w[i, col.J_W] * delta
        if w[i, col.J_RESISTS] != 0.0:
            delta += resist(i, turned, bend[i], body, dt2, w)
        step = body[i - 1, col.MASS_INV] * delta
        mov[i - 1, 0] += step * w[i, col.GA_X]
        mov[i - 1, 1] += step * w[i, col.GA_Y]
        mov[i - 1, 2] += step * w[i, col.GA_Z]
        step = body[i, col.MASS_INV] * delta
        mov[i, 0] += step * w[i, col.GM_X]
        mov[i, 1] += step * w[i, col.GM_Y]
        mov[i, 2] += step * w[i, col.GM_Z]
        step = body[i + 1, col.MASS_INV] * delta
        mov[i + 1, 0] += step * w[i, col.GB_X]
        mov[i + 1, 1] += step * w[i, col.GB_Y]
        mov[i + 1, 2] += step * w[i, col.GB_Z]


@compiled
def solve_links(n: int, mov: Floats, body: Floats, w: Floats) -> None:
    """Bring each link back to its length once, along its direction when the step began.

    So pull links as walls and joints push: as all lay when the step began. Along the directions in
    which links lie later, a robot that is spun would gain energy from the walls. (This is SHAKE:
    Ryckaert, Ciccotti and Berendsen, J. Comput. Phys. 23, 1977.)
    """
    for m in range(n - 1):
        ax = w[m, col.D_X]
        ay = w[m, col.D_Y]
        az = w[m, col.D_Z]
        dx = ax + mov[m, 0] - mov[m + 1, 0]
        dy = ay + mov[m, 1] - mov[m + 1, 1]
        dz = az + mov[m, 2] - mov[m + 1, 2]
        # (d^2 - l^2) / 2l has the same root as d - l and needs no square root.
        scale = body[m, col.LINK_LENGTH] ** 2 - dx * dx - dy * dy - dz * dz
        scale *= w[m, col.LINK_SCALE]
        ahead = scale * body[m, col.MASS_INV]
        behind = scale * body[m + 1, col.MASS_INV]
        mov[m, 0] += ahead * ax
        mov[m, 1] += ahead * ay
        mov[m, 2] += ahead * az
        mov[m + 1, 0] -= behind * ax
        mov[m + 1, 1] -= behind * ay
        mov[m + 1, 2] -= behind * az


# --- motors --------------------------------------------------------------------------------------


@compiled
def turn_roll_motor(roll: Floats, world: Floats) -> float:
    """Turn the motor side of the roll joint by one substep; return the current's share.

    It turns at rate * (1 - torque / stall torque) and is never driven back.
    """
    wanted = world[col.ROLL_TARGET] - roll[col.R_MOTOR]
    if wanted == 0.0:
        return 0.0
    against = col.TWIST_NM_RAD * (roll[col.R_MOTOR] - roll[col.R_ANGLE]) / world[col.ROLL_STALL]
    if wanted < 0.0:
        against = -against
    load = min(max(against, 0.0), 1.0)
    reach = world[col.ROLL_RATE] * (1.0 - load) * world[col.DT]
    roll[col.R_MOTOR] += min(max(wanted, -reach), reach)
    return float(load)


@compiled
def _rolled(c: int, i: int, o: int, mov: Floats, con: Floats) -> float:
    """Return how far a wheel without its motor would have rolled along the wall."""
    own = con[c, col.GI_X] * mov[i, 0]
    own += con[c, col.GI_Y] * mov[i, 1]
    own += con[c, col.GI_Z] * mov[i, 2]
    other = con[c, col.GO_X] * mov[o, 0]
    other += con[c, col.GO_Y] * mov[o, 1]
    other += con[c, col.GO_Z] * mov[o, 2]
    return float(own + other)


@compiled
def _slid(c: int, i: int, mov: Floats, parts: Floats, con: Floats, p: int) -> float:
    """Return how far a wheel has slid along its axle."""
    slid = con[c, col.SX] * mov[i, 0]
    slid += con[c, col.SY] * mov[i, 1]
    slid += con[c, col.SZ] * mov[i, 2]
    return float(slid + con[c, col.S_TURN] * parts[p, col.N_ROLL])


@compiled
def _crept(c: int, rolled: float, con: Floats) -> float:
    """Return how far a wheel has crept along its axle while it rolled."""
    friction = con[c, col.K_MU] * con[c, col.PUSH]
    return (
        float(con[c, col.K_CREEP] * abs(rolled) * con[c, col.SIDE] / friction)
        if friction > 0.0
        else 0.0
    )


@compiled
def _remember(anchor: Floats, surface: float, drive: float, side: float) -> None:
    """Keep what a wheel has left unsolved at a surface, where there is room."""
    for k in range(0, 3 * col.ANCHORS, 3):
        if anchor[k] == 0.0:
            anchor[k] = surface
            anchor[k + 1] = drive
            anchor[k + 2] = side
            return


@compiled
def turn_wheels(
    n: int,
    count: int,
    mov: Floats,
    wheel: Floats,
    anchor: Floats,
    world: Floats,
    w: Floats,
    parts: Floats,
    con: Floats,
    who: Ints,
    touch: Ints,
    tally: Floats,
) -> None:
    """Turn the wheels, and carry unsolved rolling and sliding over as the anchor.

    As in the plane: a wheel slips only if the force along the wall has reached its friction, and a
    stalled wheel keeps no anchor along its drive.
    """
    bound = world[col.ANCHOR_MAX]
    strongest(n, count, con, who, touch, tally)
    anchor[:] = 0.0
    for c in range(count):
        if con[c, col.PUSH] <= 0.0 or who[c, col.SURFACE] < 0:
            continue
        i = who[c, col.NODE]
        drive = con[c, col.DRIVE]
        side = con[c, col.SIDE]
        rolled = _rolled(c, i, who[c, col.OTHER], mov, con)
        slope = con[c, col.K_SLOPE]
        drag = world[col.ROLLING_RESISTANCE] * con[c, col.PUSH]
        bears = con[c, col.K_FORCE] + drag
        lost = slope * drive
        dragged = at_most(con[c, col.TARGET] - con[c, col.HELD] - lost, slope * drag)
        lost += dragged
        left = con[c, col.TARGET] - rolled - lost
        motor = drive + dragged / slope if slope > 0.0 else drive
        aside = (
            con[c, col.S_TARGET]
            - _slid(c, i, mov, parts, con, who[c, col.PART])
            - _crept(c, rolled, con)
        )
        tally[i, col.T_DRIVE] += min(abs(motor), con[c, col.K_FORCE]) * con[c, col.K_RADIUS]
        tally[i, col.T_GRIP] += drive
        friction = con[c, col.K_MU] * con[c, col.PUSH]
        stalled = bears < friction and abs(drive) >= REACHED * bears
        if stalled:
            left = 0.0
        away = np.sqrt(left * left + aside * aside)
        force = np.sqrt(drive * drive + side * side)
        slips = away >= bound and force >= REACHED * friction
        most = bound if slips else col.STUCK * bound
        if away > most:
            left *= most / away
            aside *= most / away
        _remember(anchor[i], who[c, col.SURFACE] + 1.0, left, aside)
        if touch[i] == c:
            if con[c, col.K_RADIUS] == 0.0 or (slips and not stalled):
                wheel[i] += w[i, col.SPIN]
                if con[c, col.K_RADIUS] != 0.0:
                    wheel[i] -= lost / con[c, col.K_RADIUS]
            else:
                wheel[i] += rolled / con[c, col.K_RADIUS]
    for i in range(n):
        if touch[i] < 0:
            wheel[i] += w[i, col.SPIN]


# --- planes of the parts -------------------------------------------------------------------------


# Stiff enough to hold a link in its plane, soft enough for few iterations [decided by trial].
_PLANE_COMPLIANCE_M_N = 1e-6


@compiled
def stand(pos: Floats, roll: Floats, world: Floats, parts: Floats) -> None:
    """Bring the parts' normals square to the roll link, and measure the roll joint."""
    r = int(world[col.ROLL_LINK])
    ex = pos[r, 0] - pos[r + 1, 0]
    ey = pos[r, 1] - pos[r + 1, 1]
    ez = pos[r, 2] - pos[r + 1, 2]
    share = 1.0 / np.sqrt(ex * ex + ey * ey + ez * ez)
    ex *= share
    ey *= share
    ez *= share
    for p in range(2):
        nx = roll[3 * p]
        ny = roll[3 * p + 1]
        nz = roll[3 * p + 2]
        off = nx * ex + ny * ey + nz * ez
        nx -= off * ex
        ny -= off * ey
        nz -= off * ez
        share = 1.0 / np.sqrt(nx * nx + ny * ny + nz * nz)
        nx *= share
        ny *= share
        nz *= share
        parts[p, col.N_ROLLED] = 0.0
        parts[p, col.N_X] = nx
        parts[p, col.N_Y] = ny
        parts[p, col.N_Z] = nz
        parts[p, col.N_BX] = ny * ez - nz * ey
        parts[p, col.N_BY] = nz * ex - nx * ez
        parts[p, col.N_BZ] = nx * ey - ny * ex
    sin = 0.0
    cos = 0.0
    for k in range(3):
        sin += parts[0, col.N_X + k] * parts[1, col.N_BX + k]
        cos += parts[0, col.N_X + k] * parts[1, col.N_X + k]
    change = np.arctan2(sin, cos) - roll[col.R_ANGLE]
    roll[col.R_ANGLE] += change - 2.0 * np.pi * np.rint(change / (2.0 * np.pi))


@compiled
def keep(roll: Floats, parts: Floats, dt: float) -> None:
    """Turn the parts' normals by what they have rolled in a substep."""
    for p in range(2):
        parts[p, col.N_ROLLED] += parts[p, col.N_ROLL]
        # Cosine and sine of an angle whose half has this tangent; it rolls by mrad.
        half = 0.5 * parts[p, col.N_ROLLED]
        share = 1.0 / (1.0 + half * half)
        cos = (1.0 - half * half) * share
        sin = 2.0 * half * share
        for k in range(3):
            roll[3 * p + k] = cos * parts[p, col.N_X + k] + sin * parts[p, col.N_BX + k]
        roll[col.R_RATE + p] = parts[p, col.N_ROLL] / dt


@compiled
def lie_in_planes(n: int, body: Floats, world: Floats, w: Floats, parts: Floats) -> None:
    """Set values and gradients of the links' coplanarity with the normals of their parts."""
    r = int(world[col.ROLL_LINK])
    compliance = _PLANE_COMPLIANCE_M_N / (world[col.DT] * world[col.DT])
    inv_r = body[r, col.MASS_INV]
    inv_s = body[r + 1, col.MASS_INV]
    length = np.sqrt(w[r, col.D_X] ** 2 + w[r, col.D_Y] ** 2 + w[r, col.D_Z] ** 2)
    for m in range(n - 1):
        if m == r:
            continue
        p = 0 if m < r else 1
        value = 0.0
        turn = 0.0
        tilt = 0.0
        for k in range(3):
            value += w[m, col.D_X + k] * parts[p, col.N_X + k]
            turn += w[m, col.D_X + k] * parts[p, col.N_BX + k]
            tilt += w[m, col.D_X + k] * w[r, col.D_X + k]
        tilt /= length * length
        w[m, col.P_C] = value
        w[m, col.P_ROLL] = turn
        w[m, col.P_TILT] = tilt
        w[m, col.P_LAM] = 0.0
        # The link shares a node with the roll link where it is next to it.
        at_r = -tilt - 1.0 if m == r - 1 else -tilt
        at_s = tilt + 1.0 if m == r + 1 else tilt
        mass_inv = inv_r * at_r * at_r + inv_s * at_s * at_s + turn * turn * parts[p, col.N_INV_I]
        if m != r + 1:
            mass_inv += body[m, col.MASS_INV]
        if m != r - 1:
            mass_inv += body[m + 1, col.MASS_INV]
        w[m, col.P_INV] = 1.0 / (mass_inv + compliance)


@compiled
def solve_planes(
    n: int, mov: Floats, body: Floats, world: Floats, w: Floats, parts: Floats, off: Floats
) -> None:
    """Bring each link into the plane of its part once.

    `off` has two rows: how far each wheel has moved out of the plane, and before this.
    """
    r = int(world[col.ROLL_LINK])
    compliance = _PLANE_COMPLIANCE_M_N / (world[col.DT] * world[col.DT])
    for p in range(2):
        first = 0 if p == 0 else r
        last = r + 1 if p == 0 else n - 1
        nx = parts[p, col.N_X]
        ny = parts[p, col.N_Y]
        nz = parts[p, col.N_Z]
        for i in range(first, last + 1):
            off[0, i] = nx * mov[i, 0] + ny * mov[i, 1] + nz * mov[i, 2]
            off[1, i] = off[0, i]
        for m in range(first, last):
            if m == r:
                continue
            tilt = w[m, col.P_TILT]
            value = w[m, col.P_C] + off[0, m] - off[0, m + 1]
            value += w[m, col.P_ROLL] * parts[p, col.N_ROLL] - tilt * (off[0, r] - off[0, r + 1])
            delta = -(value + compliance * w[m, col.P_LAM]) * w[m, col.P_INV]
            w[m, col.P_LAM] += delta
            off[0, m] += body[m, col.MASS_INV] * delta
            off[0, m + 1] -= body[m + 1, col.MASS_INV] * delta
            off[0, r] -= body[r, col.MASS_INV] * delta * tilt
            off[0, r + 1] += body[r + 1, col.MASS_INV] * delta * tilt
            parts[p, col.N_ROLL] += parts[p, col.N_INV_I] * w[m, col.P_ROLL] * delta
        for i in range(first, last + 1):
            step = off[0, i] - off[1, i]
            mov[i, 0] += step * nx
            mov[i, 1] += step * ny
            mov[i, 2] += step * nz


@compiled
def solve_twist(roll: Floats, parts: Floats, dt: float, impulse: float) -> float:
    """Pull the two parts once towards the motor of the roll joint; return the impulse so far."""
    compliance = 1.0 / (col.TWIST_NM_RAD * dt * dt)
    left = roll[col.R_MOTOR] - roll[col.R_ANGLE] - parts[0, col.N_ROLL] + parts[1, col.N_ROLL]
    both = parts[0, col.N_INV_I] + parts[1, col.N_INV_I]
    delta = (left - compliance * impulse) / (both + compliance)
    parts[0, col.N_ROLL] += parts[0, col.N_INV_I] * delta
    parts[1, col.N_ROLL] -= parts[1, col.N_INV_I] * delta
    return float(impulse + delta)
