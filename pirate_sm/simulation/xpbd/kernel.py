"""The compiled part of the kinematic simulator: extended position-based dynamics in a plane.

Python calls :func:`advance` alone; its machine code is built with the package
(`simulation/machine_code`). The modules beside this one hold the functions that it calls, and
`columns.py` the names of the columns of its arrays.

A substep is: motors, predict, iterate (joints, contacts, corners, links), velocity from
displacement (XPBD, Macklin et al. 2016). Gradients are those at the start of the substep, since
nothing turns by more than a few mrad in one; a coarser computation keeps them, and what touches
what, for some substeps. Impulses are in kg m, that is force times the squared step.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd import columns as col
from pirate_sm.simulation.xpbd.contacts import find_contacts, prepare_contacts, solve_contacts
from pirate_sm.simulation.xpbd.corners import find_corners, solve_corners
from pirate_sm.simulation.xpbd.driving import turn_roll, turn_wheels
from pirate_sm.simulation.xpbd.joints import solve_joints, solve_links
from pirate_sm.simulation.xpbd.sensing import feel, project
from pirate_sm.simulation.xpbd.substep import begin, go_on, predict, prepare

_CONTACTS_EACH = 3
_CORNERS = 4
# Blocks of `scratch`; the number times the count of wheels is where each begins. After the last one
# stand the contacts at corners and a foot. A call begins with zeros in the sums.
_AT_NODES = 0
_AT_TALLY = _AT_NODES + col.NODE_COLUMNS
_AT_CONTACTS = _AT_TALLY + col.T_COLUMNS
_AT_CORNERS = _AT_CONTACTS + _CONTACTS_EACH * col.CONTACT_COLUMNS
_FOOT = 3
# Blocks of `marks`, likewise: who touches, and the strongest contact; then which links touch.
_AT_TOUCH = 3 * _CONTACTS_EACH
_AT_WHO_CORNERS = _AT_TOUCH + 1

_WHEEL_FILTER = 0.5  # of x_velocity, a mean of angle differences (thesis B-11)


def scratch_arrays(wheels: int) -> tuple[Floats, Ints]:
    """Return arrays for `scratch` and `marks` of :func:`advance`, which keeps nothing in them."""
    return (
        np.zeros(_AT_CORNERS * wheels + _CORNERS * col.K_COLUMNS + _FOOT),
        np.zeros(_AT_WHO_CORNERS * wheels + _CORNERS, dtype=np.int64),
    )


Bars: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats, Ints, int]
"""The arguments of :func:`advance`."""


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
    motor = state[col.S_MOTOR * n : col.S_WHEEL * n]
    wheel = state[col.S_WHEEL * n : col.S_BEND * n]
    bend = state[col.S_BEND * n : col.S_ANCHOR * n]
    anchor = state[col.S_ANCHOR * n : col.S_TURNED * n].reshape(n, 4)
    turned = state[col.S_TURNED * n : col.S_READ * n]
    read = state[col.S_READ * n : col.S_ROLL * n]
    roll = state[col.S_ROLL * n : col.S_ROLL * n + 3]
    w = scratch[: _AT_TALLY * n].reshape(n, col.NODE_COLUMNS)
    tally = scratch[_AT_TALLY * n : _AT_CONTACTS * n].reshape(n, col.T_COLUMNS)
    most = _CONTACTS_EACH * n
    con = scratch[_AT_CONTACTS * n : _AT_CORNERS * n].reshape(most, col.CONTACT_COLUMNS)
    at = _AT_CORNERS * n + _CORNERS * col.K_COLUMNS
    cor = scratch[_AT_CORNERS * n : at].reshape(_CORNERS, col.K_COLUMNS)
    hit = scratch[at : at + _FOOT]
    who = marks[: _AT_TOUCH * n].reshape(most, 3)
    touch = marks[_AT_TOUCH * n : _AT_WHO_CORNERS * n]
    at_corner = marks[_AT_WHO_CORNERS * n : _AT_WHO_CORNERS * n + _CORNERS]
    tally[:] = 0.0
    dt = world[col.DT]
    compliance = world[col.CONTACT_COMPLIANCE] / (dt * dt)
    imu = min(max(int(world[col.ROLL_LINK]), 0), n - 2)
    vx = vel[imu, 0]
    vy = vel[imu, 1]
    project(n, pos, legs, out)
    prepare(n, command, body, legs, world, roll, out, w)
    count = 0
    corners = 0
    for step in range(steps):
        if step % int(world[col.LOOK]) == 0:
            begin(n, pos, bend, motor, command, body, world, w, tally)
            count = find_contacts(n, pos, vel, walls, world, con, who, hit)
            prepare_contacts(count, body, world, anchor, w, con, who)
            corners = find_corners(n, pos, walls, body, world, cor, at_corner)
        else:
            go_on(
                n, count, corners, pos, bend, motor, anchor, command, body, world, w,
                con, who, cor, at_corner, tally,
            )  # fmt: skip
        predict(n, pos, vel, dt, w)
        for k in range(int(world[col.ITERATIONS])):
            if k >= world[col.PULL]:
                solve_joints(n, pos, bend, motor, body, dt * dt, w)
            solve_contacts(count, pos, body, compliance, w, con, who)
            solve_corners(corners, pos, body, compliance, w, cor, at_corner)
            solve_links(n, pos, body, w)
        for i in range(n):
            vel[i, 0] = (pos[i, 0] - w[i, col.X0]) / dt
            vel[i, 1] = (pos[i, 1] - w[i, col.Y0]) / dt
            tally[i, col.T_TORQUE] += body[i, col.JOINT_K] * (motor[i] - bend[i])
        turn_wheels(n, count, pos, wheel, anchor, world, w, con, who, touch, tally)
    project(n, pos, legs, out)
    passed = dt * steps
    per_step = 1.0 / (dt * dt * steps)
    for i in range(n):
        turned[i] += _WHEEL_FILTER * (wheel[i] - read[i] - turned[i])
        read[i] = wheel[i]
        out[i] = bend[i]
        out[n + i] = tally[i, col.T_TORQUE] / steps
        out[2 * n + i] = tally[i, col.T_CURRENT] / steps
        out[3 * n + i] = wheel[i]
        out[4 * n + i] = turned[i]
        out[5 * n + i] = tally[i, col.T_DRIVE] * per_step * world[col.RADIUS]
        out[6 * n + i] = tally[i, col.T_PRESS] * per_step
        out[8 * n + i] = tally[i, col.T_GRIP] * per_step
    turn_roll(n, roll, body, legs, world, passed, out)
    accel_x = (vel[imu, 0] - vx) / passed
    accel_y = (vel[imu, 1] - vy) / passed
    feel(n, pos, accel_x, accel_y, legs, world, roll, out, w)
