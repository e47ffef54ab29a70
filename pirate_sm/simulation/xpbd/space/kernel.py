"""The compiled part of the kinematic simulator in space: a chain in round pipes.

Python calls :func:`advance` alone. The modules beside this one hold the functions that it calls,
and `columns.py` the names of the columns of its arrays.

The method is that of the planar kernel (`xpbd/kernel.py`). What space adds:

- A part of the robot, ahead of or behind the roll joint, lies in a plane of its own. Its unit
  normal `n` is perpendicular to the roll link's direction `e`, and rolls about it: `n` turns
  towards `b = n x e`.
- Links stay in the planes of their parts (coplanarity), and the two planes follow the motor of the
  roll joint (twist).
- Wheels are spheres. One drives along `t = n x N`, `N` the wall's normal, and slides along `s`,
  `n` in the wall. Friction bounds both by a circle, the motor the drive alone.
- The pipe is solids, whose walls count where the foot of the wheel's centre lies between two clip
  planes and outside a hole, and edges, which count where no adjacent wall does.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.driving import prepare_motors
from pirate_sm.simulation.xpbd.space import columns as col
from pirate_sm.simulation.xpbd.space.contacts import find_contacts, prepare_contacts, solve_contacts
from pirate_sm.simulation.xpbd.space.driving import turn_roll_motor, turn_wheels
from pirate_sm.simulation.xpbd.space.joints import solve_joints, solve_links
from pirate_sm.simulation.xpbd.space.leaning import find_leaning, solve_leaning
from pirate_sm.simulation.xpbd.space.planes import (
    keep,
    lie_in_planes,
    solve_planes,
    solve_twist,
    stand,
)
from pirate_sm.simulation.xpbd.space.sensing import feel, project
from pirate_sm.simulation.xpbd.space.substep import begin, go_on, predict
from pirate_sm.simulation.xpbd.space.walls import look_around

_CONTACTS_EACH = 4

# Blocks of `scratch`; the number times the count of wheels is where each begins. After the last one
# stand the two parts, a foot and a place of the centre line. A call begins with zeros in the first
# three and in the parts.
_AT_NODES = 0
_AT_MOVED = _AT_NODES + col.NODE_COLUMNS
_AT_TALLY = _AT_MOVED + 3
_AT_OFF = _AT_TALLY + col.T_COLUMNS
_AT_CONTACTS = _AT_OFF + 2
_AT_LEANING = _AT_CONTACTS + _CONTACTS_EACH * col.CONTACT_COLUMNS
_AT_PARTS = _AT_LEANING + 2 * col.K_COLUMNS
_FOOT, _SPOT = 7, 9
# Blocks of `marks`, likewise: who touches, which links lean, the strongest contact, how many solids
# are near, whether an edge is; then a row per wheel of solids, and two of edges.
_AT_WHO = 0
_AT_WHO_LEANS = _AT_WHO + 4 * _CONTACTS_EACH
_AT_TOUCH = _AT_WHO_LEANS + 2
_AT_NEARS = _AT_TOUCH + 1
_AT_RIMS = _AT_NEARS + 1
_AT_NEAR = _AT_RIMS + 1

_WHEEL_FILTER = 0.5  # of x_velocity, a mean of angle differences (thesis B-11)


def scratch_arrays(wheels: int, solids: int, edges: int) -> tuple[Floats, Ints]:
    """Return arrays for `scratch` and `marks` of :func:`advance`, which keeps nothing in them."""
    single = 2 * col.PART_COLUMNS + _FOOT + _SPOT
    return (
        np.zeros(_AT_PARTS * wheels + single),
        np.zeros((_AT_NEAR + solids + 2 * edges) * wheels, dtype=np.int64),
    )


Round: TypeAlias = tuple[
    Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats, Ints, int
]
"""The arguments of :func:`advance`."""


@compiled
def advance(
    state: Floats,
    command: Floats,
    body: Floats,
    solids: Floats,
    edges: Floats,
    points: Floats,
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
        state: See `space_state.SpaceState`; changed.
        command: Duty of the joint at each wheel, then of each wheel.
        body: `(wheels, BODY_COLUMNS)`.
        solids: `(solids, SOLID_COLUMNS)`.
        edges: `(edges, EDGE_COLUMNS)`.
        points: `(points, POINT_COLUMNS)`, of all edges in turn.
        legs: `(legs, LEG_COLUMNS)`.
        world: `(WORLD_ENTRIES,)`.
        out: `(OUT_PER_WHEEL * wheels + OUT_SINGLE + OUT_OWN,)`.
        scratch: Memory, of :func:`scratch_arrays`, which keeps nothing. Code that gets memory of
            its own counts who uses each array, which took a tenth of the time.
        marks: Memory too.
        steps: Number of substeps; at least 1.
    """
    n = body.shape[0]
    pos = state[: 3 * n].reshape(n, 3)
    vel = state[3 * n : 6 * n].reshape(n, 3)
    motor = state[col.S_MOTOR * n : col.S_WHEEL * n]
    wheel = state[col.S_WHEEL * n : col.S_BEND * n]
    bend = state[col.S_BEND * n : col.S_ANCHOR * n]
    anchor = state[col.S_ANCHOR * n : col.S_TURNED * n].reshape(n, 3 * col.ANCHORS)
    turned = state[col.S_TURNED * n : col.S_READ * n]
    read = state[col.S_READ * n : col.S_ROLL * n]
    roll = state[col.S_ROLL * n : col.S_ROLL * n + col.ROLL_ENTRIES]
    w = scratch[: _AT_MOVED * n].reshape(n, col.NODE_COLUMNS)
    mov = scratch[_AT_MOVED * n : _AT_TALLY * n].reshape(n, 3)
    tally = scratch[_AT_TALLY * n : _AT_OFF * n].reshape(n, col.T_COLUMNS)
    off = scratch[_AT_OFF * n : _AT_CONTACTS * n].reshape(2, n)
    most = _CONTACTS_EACH * n
    con = scratch[_AT_CONTACTS * n : _AT_LEANING * n].reshape(most, col.CONTACT_COLUMNS)
    cor = scratch[_AT_LEANING * n : _AT_PARTS * n].reshape(2 * n, col.K_COLUMNS)
    at = _AT_PARTS * n + 2 * col.PART_COLUMNS
    parts = scratch[_AT_PARTS * n : at].reshape(2, col.PART_COLUMNS)
    hit = scratch[at : at + _FOOT]
    spot = scratch[at + _FOOT : at + _FOOT + _SPOT]
    who = marks[: _AT_WHO_LEANS * n].reshape(most, 4)
    leaning = marks[_AT_WHO_LEANS * n : _AT_TOUCH * n]
    touch = marks[_AT_TOUCH * n : _AT_NEARS * n]
    nears = marks[_AT_NEARS * n : _AT_RIMS * n]
    rims = marks[_AT_RIMS * n : _AT_NEAR * n]
    at = (_AT_NEAR + solids.shape[0]) * n
    near = marks[_AT_NEAR * n : at].reshape(n, solids.shape[0])
    rim_at = marks[at : at + edges.shape[0] * n].reshape(n, edges.shape[0])
    at += edges.shape[0] * n
    link_at = marks[at : at + edges.shape[0] * n].reshape(n, edges.shape[0])
    scratch[: _AT_OFF * n] = 0.0
    parts[:] = 0.0
    dt = world[col.DT]
    passed = dt * steps
    compliance = world[col.CONTACT_COMPLIANCE] / (dt * dt)
    imu = int(world[col.IMU_LINK])
    vx, vy, vz = vel[imu, 0], vel[imu, 1], vel[imu, 2]
    parts[0, col.N_INV_I] = 1.0 / world[col.INERTIA_FRONT]
    parts[1, col.N_INV_I] = 1.0 / world[col.INERTIA_REAR]
    prepare_motors(n, command, body, world, w)
    look_around(
        n, pos, vel, body, solids, edges, points, world, passed, near, nears, rims, rim_at, link_at
    )
    current, deepest = 0.0, 0.0
    count, leans = 0, 0
    for step in range(steps):
        if step % int(world[col.LOOK]) == 0:
            stand(pos, roll, world, parts)
            begin(n, pos, bend, motor, command, body, world, w, parts, tally)
            lie_in_planes(n, body, world, w, parts)
            count = find_contacts(
                n, pos, vel, solids, edges, points, world, near, nears, rims, rim_at, con, who, hit
            )
            prepare_contacts(count, body, world, anchor, w, parts, con, who)
            leans = find_leaning(
                n, pos, solids, edges, points, body, world, near, nears, rims, link_at,
                cor, leaning, hit,
            )  # fmt: skip
        else:
            go_on(
                n, count, leans, mov, roll, bend, motor, anchor, command, body, world, w, parts,
                con, who, cor, leaning, tally,
            )  # fmt: skip
        current += turn_roll_motor(roll, world)
        for c in range(count):
            deepest = min(deepest, con[c, col.DISTANCE])
        for c in range(leans):
            deepest = min(deepest, cor[c, col.K_GAP])
        predict(n, mov, vel, roll, world, parts)
        twist = 0.0
        for k in range(int(world[col.ITERATIONS])):
            if k >= world[col.PULL]:
                solve_joints(n, mov, bend, motor, body, dt * dt, w)
            solve_planes(n, mov, body, world, w, parts, off)
            twist = solve_twist(roll, parts, dt, twist)
            solve_contacts(count, mov, body, compliance, parts, con, who)
            solve_leaning(leans, mov, body, compliance, w, cor, leaning)
            solve_links(n, mov, body, w)
        for i in range(n):
            for k in range(3):
                vel[i, k] = mov[i, k] / dt
                pos[i, k] += mov[i, k]
            tally[i, col.T_TORQUE] += body[i, col.JOINT_K] * (motor[i] - bend[i])
        turn_wheels(n, count, mov, wheel, anchor, world, w, parts, con, who, touch, tally)
        keep(roll, parts, dt)
    stand(pos, roll, world, parts)
    project(n, pos, legs, world, parts, spot, out)
    per_step = 1.0 / (dt * dt * steps)
    for i in range(n):
        turned[i] += _WHEEL_FILTER * (wheel[i] - read[i] - turned[i])
        read[i] = wheel[i]
        out[i] = bend[i]
        out[n + i] = tally[i, col.T_TORQUE] / steps
        out[2 * n + i] = tally[i, col.T_CURRENT] / steps
        out[3 * n + i] = wheel[i]
        out[4 * n + i] = turned[i]
        out[5 * n + i] = tally[i, col.T_DRIVE] * per_step
        out[6 * n + i] = tally[i, col.T_PRESS] * per_step
        out[8 * n + i] = tally[i, col.T_GRIP] * per_step
    out[col.OUT_PER_WHEEL * n] = roll[col.R_ANGLE]
    out[col.OUT_PER_WHEEL * n + 1] = current / steps
    own = col.OUT_PER_WHEEL * n + col.OUT_SINGLE
    out[own + col.OUT_ROLL] = roll[col.R_ANGLE]
    out[own + col.OUT_DEEPEST] = max(out[own + col.OUT_DEEPEST], -deepest)
    feel(
        n, pos, (vel[imu, 0] - vx) / passed, (vel[imu, 1] - vy) / passed,
        (vel[imu, 2] - vz) / passed, world, parts, out,
    )  # fmt: skip
