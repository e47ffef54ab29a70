"""How a call and each of its substeps begin, before anything is pulled or pushed."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd import columns as col
from pirate_sm.simulation.xpbd.contacts import aim
from pirate_sm.simulation.xpbd.corners import clear
from pirate_sm.simulation.xpbd.driving import lies, prepare_motors, turn_motor
from pirate_sm.simulation.xpbd.joints import turned_rad

# A joint farther from its end stops than this cannot reach them in one substep.
_STOP_RAD = 0.1


@compiled
def prepare(
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
    prepare_motors(n, command, body, world, w)
    dt = world[col.DT]
    leg_of = (col.OUT_PER_WHEEL + 1) * n + col.OUT_SINGLE
    front, rear = roll[1], roll[2]
    if front != rear:
        front_lies = lies(n, 1, body, legs, world, out)
        rear_lies = lies(n, 2, body, legs, world, out)
        # The joints of the holding part bear the weight of the other one, in their own plane.
        if front_lies and not rear_lies:
            front = rear
        elif rear_lies and not front_lies:
            rear = front
    for i in range(n):
        leg = legs[int(out[leg_of + i])]
        part = front if i <= world[col.ROLL_LINK] else rear
        across = leg[col.L_GN]
        if part != 0.0:
            across = leg[col.L_GN] * np.cos(part) - leg[col.L_GB] * np.sin(part)
        w[i, col.G_X] = leg[col.L_GT] * leg[col.L_TX] - across * leg[col.L_TY]
        w[i, col.G_Y] = leg[col.L_GT] * leg[col.L_TY] + across * leg[col.L_TX]
        # A wheel that presses on no wall lies on the floor and drags by its weight.
        floor = abs(leg[col.L_GN] * np.sin(part) + leg[col.L_GB] * np.cos(part))
        w[i, col.DRAG] = body[i, col.MU_KINETIC] * floor * dt if out[6 * n + i] == 0.0 else 0.0


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
    tally: Floats,
) -> None:
    """Compute angles and gradients from the positions, and turn the motors by one substep."""
    dt = world[col.DT]
    before = 0.0
    for i in range(n):
        w[i, col.X0] = pos[i, 0]
        w[i, col.Y0] = pos[i, 1]
        if i == n - 1:
            break
        ex = pos[i, 0] - pos[i + 1, 0]
        ey = pos[i, 1] - pos[i + 1, 1]
        length2 = ex * ex + ey * ey
        w[i, col.LEVER_X] = -ey / length2
        w[i, col.LEVER_Y] = ex / length2
        heading = np.arctan2(ey, ex)
        change = heading - before - bend[i]
        before = heading
        if i == 0:
            continue
        if abs(change) > np.pi:
            change -= 2.0 * np.pi * np.rint(change / (2.0 * np.pi))
        bend[i] += change
        turn_motor(i, command[i], bend, motor, body, dt, w, tally)
        w[i, col.GA_X] = -w[i - 1, col.LEVER_X]
        w[i, col.GA_Y] = -w[i - 1, col.LEVER_Y]
        w[i, col.GB_X] = -w[i, col.LEVER_X]
        w[i, col.GB_Y] = -w[i, col.LEVER_Y]
        w[i, col.GM_X] = w[i, col.LEVER_X] + w[i - 1, col.LEVER_X]
        w[i, col.GM_Y] = w[i, col.LEVER_Y] + w[i - 1, col.LEVER_Y]
        w[i, col.J_W] = (
            body[i - 1, col.MASS_INV] * (w[i, col.GA_X] ** 2 + w[i, col.GA_Y] ** 2)
            + body[i, col.MASS_INV] * (w[i, col.GM_X] ** 2 + w[i, col.GM_Y] ** 2)
            + body[i + 1, col.MASS_INV] * (w[i, col.GB_X] ** 2 + w[i, col.GB_Y] ** 2)
        )
        w[i, col.J_INV] = 1.0 / ((1.0 + w[i, col.J_D]) * w[i, col.J_W] + w[i, col.J_C])
        free = body[i, col.JOINT_MIN] + _STOP_RAD < bend[i] < body[i, col.JOINT_MAX] - _STOP_RAD
        w[i, col.J_RESISTS] = 0.0 if free and body[i, col.JOINT_FRICTION] == 0.0 else 1.0


@compiled
def go_on(
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
        bend[i] += turned_rad(i, pos, w)
        turn_motor(i, command[i], bend, motor, body, world[col.DT], w, tally)
    for c in range(count):
        i = who[c, col.NODE]
        con[c, col.GAP] += con[c, col.NX] * (pos[i, 0] - w[i, col.X0]) + con[c, col.NY] * (
            pos[i, 1] - w[i, col.Y0]
        )
        aim(c, i, body, world, anchor, w, con, who)
    for c in range(corners):
        cor[c, col.K_GAP] = clear(c, at_corner[c], pos, w, cor)
        cor[c, col.K_PUSH] = 0.0
    for i in range(n):
        w[i, col.X0] = pos[i, 0]
        w[i, col.Y0] = pos[i, 1]


@compiled
def predict(n: int, pos: Floats, vel: Floats, dt: float, w: Floats) -> None:
    """Move the wheels as gravity and the floor's friction alone would."""
    for i in range(n):
        vx = vel[i, 0] + dt * w[i, col.G_X]
        vy = vel[i, 1] + dt * w[i, col.G_Y]
        if w[i, col.DRAG] > 0.0:
            speed = np.sqrt(vx * vx + vy * vy)
            left = 1.0 - w[i, col.DRAG] / speed if speed > w[i, col.DRAG] else 0.0
            vx *= left
            vy *= left
        pos[i, 0] += dt * vx
        pos[i, 1] += dt * vy
