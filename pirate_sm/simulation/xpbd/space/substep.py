"""How each substep begins, before anything is pulled or pushed."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.driving import turn_motor
from pirate_sm.simulation.xpbd.space import columns as col
from pirate_sm.simulation.xpbd.space.contacts import press, recall
from pirate_sm.simulation.xpbd.space.joints import turned_rad
from pirate_sm.simulation.xpbd.space.leaning import clear

# A joint farther from its end stops than this cannot reach them in one substep.
_STOP_RAD = 0.1


@compiled
def begin(
    n: int,
    pos: Floats,
    bend: Floats,
    motor: Floats,
    command: Floats,
    body: Floats,
    world: Floats,
    w: Floats,
    parts: Floats,
    tally: Floats,
) -> None:
    """Compute angles and gradients from the positions, and turn the motors by one substep."""
    dt = world[col.DT]
    r = int(world[col.ROLL_LINK])
    for i in range(n - 1):
        dx = pos[i, 0] - pos[i + 1, 0]
        dy = pos[i, 1] - pos[i + 1, 1]
        dz = pos[i, 2] - pos[i + 1, 2]
        w[i, col.D_X] = dx
        w[i, col.D_Y] = dy
        w[i, col.D_Z] = dz
        share = 1.0 / (dx * dx + dy * dy + dz * dz)
        p = 0 if i <= r else 1
        nx = parts[p, col.N_X]
        ny = parts[p, col.N_Y]
        nz = parts[p, col.N_Z]
        w[i, col.LF_X] = (ny * dz - nz * dy) * share
        w[i, col.LF_Y] = (nz * dx - nx * dz) * share
        w[i, col.LF_Z] = (nx * dy - ny * dx) * share
        if i == r:
            w[i, col.LR_X] = (parts[1, col.N_Y] * dz - parts[1, col.N_Z] * dy) * share
            w[i, col.LR_Y] = (parts[1, col.N_Z] * dx - parts[1, col.N_X] * dz) * share
            w[i, col.LR_Z] = (parts[1, col.N_X] * dy - parts[1, col.N_Y] * dx) * share
        else:
            for k in range(3):
                w[i, col.LR_X + k] = w[i, col.LF_X + k]
        if i == 0:
            continue
        ax = w[i - 1, col.D_X]
        ay = w[i - 1, col.D_Y]
        az = w[i - 1, col.D_Z]
        sin = nx * (ay * dz - az * dy) + ny * (az * dx - ax * dz) + nz * (ax * dy - ay * dx)
        cos = ax * dx + ay * dy + az * dz
        cos -= (nx * ax + ny * ay + nz * az) * (nx * dx + ny * dy + nz * dz)
        change = np.arctan2(sin, cos) - bend[i]
        if abs(change) > np.pi:
            change -= 2.0 * np.pi * np.rint(change / (2.0 * np.pi))
        bend[i] += change
        turn_motor(i, command[i], bend, motor, body, dt, w, tally)
        inv = 0.0
        for k in range(3):
            w[i, col.GA_X + k] = -w[i - 1, col.LR_X + k]
            w[i, col.GB_X + k] = -w[i, col.LF_X + k]
            w[i, col.GM_X + k] = w[i, col.LF_X + k] + w[i - 1, col.LR_X + k]
            inv += body[i - 1, col.MASS_INV] * w[i, col.GA_X + k] ** 2
            inv += body[i, col.MASS_INV] * w[i, col.GM_X + k] ** 2
            inv += body[i + 1, col.MASS_INV] * w[i, col.GB_X + k] ** 2
        w[i, col.J_W] = inv
        w[i, col.J_INV] = 1.0 / ((1.0 + w[i, col.J_D]) * inv + w[i, col.J_C])
        free = body[i, col.JOINT_MIN] + _STOP_RAD < bend[i] < body[i, col.JOINT_MAX] - _STOP_RAD
        w[i, col.J_RESISTS] = 0.0 if free and body[i, col.JOINT_FRICTION] == 0.0 else 1.0


@compiled
def go_on(
    n: int,
    count: int,
    leans: int,
    mov: Floats,
    roll: Floats,
    bend: Floats,
    motor: Floats,
    anchor: Floats,
    command: Floats,
    body: Floats,
    world: Floats,
    w: Floats,
    parts: Floats,
    con: Floats,
    who: Ints,
    cor: Floats,
    leaning: Ints,
    tally: Floats,
) -> None:
    """Begin a substep with the directions and contacts of the one before.

    Angles, distances and links change by what the wheels have moved.
    """
    r = int(world[col.ROLL_LINK])
    roll[col.R_ANGLE] += parts[0, col.N_ROLL] - parts[1, col.N_ROLL]
    for p in range(2):
        nx = parts[p, col.N_X]
        ny = parts[p, col.N_Y]
        nz = parts[p, col.N_Z]
        tilted = nx * (mov[r, 0] - mov[r + 1, 0])
        tilted += ny * (mov[r, 1] - mov[r + 1, 1])
        tilted += nz * (mov[r, 2] - mov[r + 1, 2])
        for m in range(0 if p == 0 else r + 1, r if p == 0 else n - 1):
            off = nx * (mov[m, 0] - mov[m + 1, 0])
            off += ny * (mov[m, 1] - mov[m + 1, 1])
            off += nz * (mov[m, 2] - mov[m + 1, 2])
            w[m, col.P_C] += (
                off + w[m, col.P_ROLL] * parts[p, col.N_ROLL] - w[m, col.P_TILT] * tilted
            )
            w[m, col.P_LAM] = 0.0
    for m in range(n - 1):
        for k in range(3):
            w[m, col.D_X + k] += mov[m, k] - mov[m + 1, k]
    for i in range(1, n - 1):
        bend[i] += turned_rad(i, mov, w)
        turn_motor(i, command[i], bend, motor, body, world[col.DT], w, tally)
    for c in range(count):
        i = who[c, col.NODE]
        con[c, col.DISTANCE] += (
            con[c, col.NX] * mov[i, 0] + con[c, col.NY] * mov[i, 1] + con[c, col.NZ] * mov[i, 2]
        )
        press(c, con)
        if who[c, col.SURFACE] >= 0:
            recall(c, i, body, world, anchor, con, who)
            con[c, col.TARGET] += w[i, col.SPIN] * con[c, col.K_RADIUS]
    for c in range(leans):
        cor[c, col.K_GAP] = clear(c, leaning[c], mov, cor)
        cor[c, col.K_PUSH] = 0.0


@compiled
def predict(n: int, mov: Floats, vel: Floats, roll: Floats, world: Floats, parts: Floats) -> None:
    """Move the wheels as gravity alone would, and roll the parts on."""
    dt = world[col.DT]
    for i in range(n):
        for k in range(3):
            mov[i, k] = dt * (vel[i, k] + dt * world[col.G_X + k])
    for p in range(2):
        parts[p, col.N_ROLL] = dt * roll[col.R_RATE + p]
