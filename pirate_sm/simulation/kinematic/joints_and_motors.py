"""Joints between links, their length, and the motors of joints, wheels and the roll joint."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.kinematic import columns as col
from pirate_sm.simulation.kinematic.contacts import at_most, rolled_m
from pirate_sm.simulation.machine_code import compiled

# --- joints --------------------------------------------------------------------------------------


@compiled
def turned_rad(i: int, pos: Floats, w: Floats) -> float:
    """Return by how much a joint has turned in this substep."""
    # Three short sums, because one long sum would wait for each of its terms in turn.
    ahead = w[i, col.GA_X] * (pos[i - 1, 0] - w[i - 1, col.X0])
    ahead += w[i, col.GA_Y] * (pos[i - 1, 1] - w[i - 1, col.Y0])
    middle = w[i, col.GM_X] * (pos[i, 0] - w[i, col.X0]) + w[i, col.GM_Y] * (
        pos[i, 1] - w[i, col.Y0]
    )
    behind = w[i, col.GB_X] * (pos[i + 1, 0] - w[i + 1, col.X0])
    behind += w[i, col.GB_Y] * (pos[i + 1, 1] - w[i + 1, col.Y0])
    return float(behind + middle + ahead)


@compiled
def resist(i: int, turned: float, bend: float, body: Floats, dt2: float, w: Floats) -> float:
    """Return the impulse that a joint's dry friction and end stops add after it has turned."""
    added = 0.0
    if body[i, col.JOINT_FRICTION] > 0.0:
        limit = body[i, col.JOINT_FRICTION] * dt2
        new = min(max(w[i, col.J_FRICTION] - turned / w[i, col.J_W], -limit), limit)
        added = new - w[i, col.J_FRICTION]
        w[i, col.J_FRICTION] = new
    angle = bend + turned + added * w[i, col.J_W]
    old = w[i, col.J_STOP]
    if angle > body[i, col.JOINT_MAX] or old < 0.0:
        w[i, col.J_STOP] = min(0.0, old - (angle - body[i, col.JOINT_MAX]) / w[i, col.J_W])
    elif angle < body[i, col.JOINT_MIN] or old > 0.0:
        w[i, col.J_STOP] = max(0.0, old - (angle - body[i, col.JOINT_MIN]) / w[i, col.J_W])
    return float(added + w[i, col.J_STOP] - old)


@compiled
def solve_joints(
    n: int, pos: Floats, bend: Floats, motor: Floats, body: Floats, dt2: float, w: Floats
) -> None:
    """Pull each joint once towards its motor-side angle through its spring."""
    for i in range(1, n - 1):
        turned = turned_rad(i, pos, w)
        left = motor[i] - bend[i] - turned * (1.0 + w[i, col.J_D]) - w[i, col.J_C] * w[i, col.J_LAM]
        delta = left * w[i, col.J_INV]
        w[i, col.J_LAM] += delta
        turned += w[i, col.J_W] * delta
        if w[i, col.J_RESISTS] != 0.0:
            delta += resist(i, turned, bend[i], body, dt2, w)
        step = body[i - 1, col.MASS_INV] * delta
        pos[i - 1, 0] += step * w[i, col.GA_X]
        pos[i - 1, 1] += step * w[i, col.GA_Y]
        step = body[i, col.MASS_INV] * delta
        pos[i, 0] += step * w[i, col.GM_X]
        pos[i, 1] += step * w[i, col.GM_Y]
        step = body[i + 1, col.MASS_INV] * delta
        pos[i + 1, 0] += step * w[i, col.GB_X]
        pos[i + 1, 1] += step * w[i, col.GB_Y]


@compiled
def solve_links(n: int, pos: Floats, body: Floats, w: Floats) -> None:
    """Bring each link back to its length once."""
    for m in range(n - 1):
        dx = pos[m, 0] - pos[m + 1, 0]
        dy = pos[m, 1] - pos[m + 1, 1]
        # (d^2 - l^2) / 2l has the same root as d - l and needs no square root.
        scale = (body[m, col.LINK_LENGTH] ** 2 - dx * dx - dy * dy) * w[m, col.LINK_SCALE]
        ahead = scale * body[m, col.MASS_INV]
        behind = scale * body[m + 1, col.MASS_INV]
        pos[m, 0] += ahead * dx
        pos[m, 1] += ahead * dy
        pos[m + 1, 0] -= behind * dx
        pos[m + 1, 1] -= behind * dy


# --- motors --------------------------------------------------------------------------------------


# The motor side of a spring may wind this far beyond the joint's own end stop.
_WINDING_RAD = 0.6
# Share of its limit from which a force counts as having reached it.
REACHED = 0.9999
# A part that lies in the pipe presses with up to its weight, and little more where its joints still
# bear some torque. A part that was clamped and is relaxed presses with at least 4 weights.
_LYING_WEIGHTS = 2.0


@compiled
def prepare_motors(n: int, command: Floats, body: Floats, world: Floats, w: Floats) -> None:
    """Set what is constant during a call: limits of motors, compliances of joints, of links."""
    dt = world[col.DT]
    radius = world[col.RADIUS]
    for i in range(n):
        duty = command[n + i]
        w[i, col.SPIN] = duty * body[i, col.WHEEL_RATE] * dt
        w[i, col.SLOPE] = 0.0
        w[i, col.FORCE] = body[i, col.WHEEL_HOLD] / radius * dt * dt
        if duty != 0.0:
            w[i, col.FORCE] = body[i, col.WHEEL_STALL] / radius * dt * dt
            w[i, col.SLOPE] = body[i, col.WHEEL_RATE] * radius**2 / (body[i, col.WHEEL_STALL] * dt)
        w[i, col.J_C] = 1.0 / (body[i, col.JOINT_K] * dt * dt)
        w[i, col.J_D] = body[i, col.JOINT_DAMPING] / (body[i, col.JOINT_K] * dt)
        if i < n - 1:
            both = body[i, col.MASS_INV] + body[i + 1, col.MASS_INV]
            w[i, col.LINK_SCALE] = 0.5 / (body[i, col.LINK_LENGTH] ** 2 * both)


@compiled
def turn_motor(
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
    rate = duty - body[i, col.JOINT_K] * (motor[i] - bend[i]) / body[i, col.JOINT_STALL]
    rate = min(max(rate, min(duty, 0.0)), max(duty, 0.0))
    turned = motor[i] + body[i, col.JOINT_RATE] * rate * dt
    motor[i] = min(
        max(turned, body[i, col.JOINT_MIN] - _WINDING_RAD), body[i, col.JOINT_MAX] + _WINDING_RAD
    )
    tally[i, col.T_CURRENT] += abs(duty - rate)
    w[i, col.J_LAM] = 0.0
    w[i, col.J_FRICTION] = 0.0
    w[i, col.J_STOP] = 0.0


@compiled
def strongest(n: int, count: int, con: Floats, who: Ints, touch: Ints, tally: Floats) -> None:
    """Write the strongest wall contact of each wheel to `touch`, -1 without any."""
    for i in range(n):
        touch[i] = -1
    for c in range(count):
        i = who[c, col.NODE]
        if con[c, col.PUSH] > 0.0 and who[c, col.KEY] >= 0:
            tally[i, col.T_PRESS] += con[c, col.PUSH]
            if touch[i] < 0 or con[c, col.PUSH] > con[touch[i], col.PUSH]:
                touch[i] = c


@compiled
def turn_wheels(
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
    radius = world[col.RADIUS]
    bound = world[col.ANCHOR_MAX]
    strongest(n, count, con, who, touch, tally)
    anchor[:] = 0.0
    for c in range(count):
        if con[c, col.PUSH] <= 0.0 or who[c, col.KEY] < 0:
            continue
        i = who[c, col.NODE]
        rolled = rolled_m(c, i, who[c, col.OTHER], pos, w, con)
        force = con[c, col.ROLLING]
        slope = con[c, col.C_SLOPE]
        drag = world[col.ROLLING_RESISTANCE] * con[c, col.PUSH]
        bears = con[c, col.C_FORCE] + drag
        lost = slope * force
        dragged = at_most(con[c, col.TARGET] - con[c, col.HELD] - lost, slope * drag)
        lost += dragged
        left = con[c, col.TARGET] - rolled - lost
        motor = force + dragged / slope if slope > 0.0 else force
        tally[i, col.T_DRIVE] += min(abs(motor), con[c, col.C_FORCE])
        tally[i, col.T_GRIP] += force
        friction = con[c, col.C_MU] * con[c, col.PUSH]
        stalled = bears < friction and abs(force) >= REACHED * bears
        slips = abs(left) >= bound and not stalled and abs(force) >= REACHED * friction
        if not stalled:
            most = bound if slips else col.STUCK * bound
            anchor[i, who[c, col.KEY]] = min(max(left, -most), most)
        if touch[i] == c:
            wheel[i] += w[i, col.SPIN] - lost / radius if slips else rolled / radius
    for i in range(n):
        if touch[i] < 0:
            wheel[i] += w[i, col.SPIN]


@compiled
def lies(n: int, part: int, body: Floats, legs: Floats, world: Floats, out: Floats) -> bool:
    """Return whether a part (1: ahead of the roll joint, 2: behind) lies in the pipe, unwedged."""
    press, mass = 0.0, 0.0
    for i in range(n):
        if (i <= world[col.ROLL_LINK]) == (part == 1):
            press += out[6 * n + i]
            mass += 1.0 / body[i, col.MASS_INV]
    gravity = np.sqrt(legs[0, col.L_GT] ** 2 + legs[0, col.L_GN] ** 2 + legs[0, col.L_GB] ** 2)
    return bool(press <= _LYING_WEIGHTS * mass * gravity)


@compiled
def turn_roll(
    n: int, roll: Floats, body: Floats, legs: Floats, world: Floats, passed: float, out: Floats
) -> None:
    """Turn the roll joint towards its target, as far as one of the parts can turn.

    A part that presses on the walls with much more than its own weight is wedged and does not
    turn. A part that only lies there turns against the friction of its wheels, with the pipe's
    radius as lever. If both parts could turn, the one with less friction does.

    The current is the motor's share of its stall torque: all of it while it stalls.
    """
    k = col.OUT_PER_WHEEL * n
    out[k] = roll[0]
    out[k + 1] = 0.0
    wanted = world[col.ROLL_TARGET] - roll[0]
    if wanted == 0.0:
        return
    part, friction = 0, np.inf
    for half in (1, 2):
        if not lies(n, half, body, legs, world, out):
            continue
        torque = 0.0
        for i in range(n):
            if (i <= world[col.ROLL_LINK]) == (half == 1):
                torque += body[i, col.MU_STATIC] * out[6 * n + i] * world[col.DEPTH]
        if torque < friction:
            part, friction = half, torque
    load = friction / world[col.ROLL_STALL]
    if part == 0 or load >= 1.0:
        out[k + 1] = 1.0
        return
    reach = world[col.ROLL_RATE] * (1.0 - load) * passed
    turn = min(max(wanted, -reach), reach)
    roll[0] += turn
    roll[part] += turn if part == 1 else -turn
    out[k] = roll[0]
    out[k + 1] = load
