"""How a call and each of its substeps begin, before anything is pulled or pushed."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.space.columns import (
    D_X,
    D_Y,
    D_Z,
    DISTANCE,
    DT,
    FORCE,
    G_X,
    GA_X,
    GB_X,
    GM_X,
    J_C,
    J_D,
    J_INV,
    J_RESISTS,
    J_W,
    JOINT_DAMPING,
    JOINT_FRICTION,
    JOINT_K,
    JOINT_MAX,
    JOINT_MIN,
    K_GAP,
    K_PUSH,
    K_RADIUS,
    LF_X,
    LF_Y,
    LF_Z,
    LINK_LENGTH,
    LINK_SCALE,
    LR_X,
    LR_Y,
    LR_Z,
    MASS_INV,
    N_ROLL,
    N_X,
    N_Y,
    N_Z,
    NODE,
    NX,
    NY,
    NZ,
    P_C,
    P_LAM,
    P_ROLL,
    P_TILT,
    R_ANGLE,
    R_RATE,
    RADIUS,
    ROLL_LINK,
    SLOPE,
    SPIN,
    SURFACE,
    TARGET,
    WHEEL_HOLD,
    WHEEL_RATE,
    WHEEL_STALL,
)
from pirate_sm.simulation.xpbd.space.contacts import press, recall
from pirate_sm.simulation.xpbd.space.driving import turn_motor
from pirate_sm.simulation.xpbd.space.joints import turned_rad
from pirate_sm.simulation.xpbd.space.leaning import clear

# A joint farther from its end stops than this cannot reach them in one substep.
_STOP_RAD = 0.1


@compiled
def prepare(n: int, command: Floats, body: Floats, world: Floats, w: Floats) -> None:
    """Set what is constant during a call: motor limits, compliances."""
    dt = world[DT]
    radius = world[RADIUS]
    for i in range(n):
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
    dt = world[DT]
    r = int(world[ROLL_LINK])
    for i in range(n - 1):
        dx = pos[i, 0] - pos[i + 1, 0]
        dy = pos[i, 1] - pos[i + 1, 1]
        dz = pos[i, 2] - pos[i + 1, 2]
        w[i, D_X] = dx
        w[i, D_Y] = dy
        w[i, D_Z] = dz
        share = 1.0 / (dx * dx + dy * dy + dz * dz)
        p = 0 if i <= r else 1
        nx = parts[p, N_X]
        ny = parts[p, N_Y]
        nz = parts[p, N_Z]
        w[i, LF_X] = (ny * dz - nz * dy) * share
        w[i, LF_Y] = (nz * dx - nx * dz) * share
        w[i, LF_Z] = (nx * dy - ny * dx) * share
        if i == r:
            w[i, LR_X] = (parts[1, N_Y] * dz - parts[1, N_Z] * dy) * share
            w[i, LR_Y] = (parts[1, N_Z] * dx - parts[1, N_X] * dz) * share
            w[i, LR_Z] = (parts[1, N_X] * dy - parts[1, N_Y] * dx) * share
        else:
            for k in range(3):
                w[i, LR_X + k] = w[i, LF_X + k]
        if i == 0:
            continue
        ax = w[i - 1, D_X]
        ay = w[i - 1, D_Y]
        az = w[i - 1, D_Z]
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
            w[i, GA_X + k] = -w[i - 1, LR_X + k]
            w[i, GB_X + k] = -w[i, LF_X + k]
            w[i, GM_X + k] = w[i, LF_X + k] + w[i - 1, LR_X + k]
            inv += body[i - 1, MASS_INV] * w[i, GA_X + k] ** 2
            inv += body[i, MASS_INV] * w[i, GM_X + k] ** 2
            inv += body[i + 1, MASS_INV] * w[i, GB_X + k] ** 2
        w[i, J_W] = inv
        w[i, J_INV] = 1.0 / ((1.0 + w[i, J_D]) * inv + w[i, J_C])
        free = body[i, JOINT_MIN] + _STOP_RAD < bend[i] < body[i, JOINT_MAX] - _STOP_RAD
        w[i, J_RESISTS] = 0.0 if free and body[i, JOINT_FRICTION] == 0.0 else 1.0


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
    r = int(world[ROLL_LINK])
    roll[R_ANGLE] += parts[0, N_ROLL] - parts[1, N_ROLL]
    for p in range(2):
        nx = parts[p, N_X]
        ny = parts[p, N_Y]
        nz = parts[p, N_Z]
        tilted = nx * (mov[r, 0] - mov[r + 1, 0])
        tilted += ny * (mov[r, 1] - mov[r + 1, 1])
        tilted += nz * (mov[r, 2] - mov[r + 1, 2])
        for m in range(0 if p == 0 else r + 1, r if p == 0 else n - 1):
            off = nx * (mov[m, 0] - mov[m + 1, 0])
            off += ny * (mov[m, 1] - mov[m + 1, 1])
            off += nz * (mov[m, 2] - mov[m + 1, 2])
            w[m, P_C] += off + w[m, P_ROLL] * parts[p, N_ROLL] - w[m, P_TILT] * tilted
            w[m, P_LAM] = 0.0
    for m in range(n - 1):
        for k in range(3):
            w[m, D_X + k] += mov[m, k] - mov[m + 1, k]
    for i in range(1, n - 1):
        bend[i] += turned_rad(i, mov, w)
        turn_motor(i, command[i], bend, motor, body, world[DT], w, tally)
    for c in range(count):
        i = who[c, NODE]
        con[c, DISTANCE] += con[c, NX] * mov[i, 0] + con[c, NY] * mov[i, 1] + con[c, NZ] * mov[i, 2]
        press(c, con)
        if who[c, SURFACE] >= 0:
            recall(c, i, body, world, anchor, con, who)
            con[c, TARGET] += w[i, SPIN] * con[c, K_RADIUS]
    for c in range(leans):
        cor[c, K_GAP] = clear(c, leaning[c], mov, cor)
        cor[c, K_PUSH] = 0.0


@compiled
def predict(n: int, mov: Floats, vel: Floats, roll: Floats, world: Floats, parts: Floats) -> None:
    """Move the wheels as gravity alone would, and roll the parts on."""
    dt = world[DT]
    for i in range(n):
        for k in range(3):
            mov[i, k] = dt * (vel[i, k] + dt * world[G_X + k])
    for p in range(2):
        parts[p, N_ROLL] = dt * roll[R_RATE + p]
