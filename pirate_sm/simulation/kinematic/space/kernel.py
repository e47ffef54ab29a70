"""The compiled part of the kinematic simulator in space: a chain in round pipes.

Python calls :func:`advance` and, for many cycles, :func:`glide` and :func:`pass_cycles`. The other
modules of this folder hold functions that they call, and `columns.py` the names of the columns of
their arrays.

The method is that of the planar kernel (`kinematic/kernel.py`). What space adds:

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

from pirate_sm.simulation.arrays import Floats, Ints, Words
from pirate_sm.simulation.gliding import columns as gliding
from pirate_sm.simulation.gliding.cycle import goes_on, may_begin, may_pass, note_places, passes_on
from pirate_sm.simulation.kinematic.joints_and_motors import prepare_motors, turn_motor
from pirate_sm.simulation.kinematic.space import columns as col
from pirate_sm.simulation.kinematic.space.contacts import (
    clear,
    find_contacts,
    find_leaning,
    prepare_contacts,
    press,
    recall,
    solve_contacts,
    solve_leaning,
)
from pirate_sm.simulation.kinematic.space.joints_and_motors import (
    keep,
    lie_in_planes,
    solve_joints,
    solve_links,
    solve_planes,
    solve_twist,
    stand,
    turn_roll_motor,
    turn_wheels,
    turned_rad,
)
from pirate_sm.simulation.kinematic.space.sensing import feel, project
from pirate_sm.simulation.kinematic.space.walls import look_around
from pirate_sm.simulation.machine_code import compiled

# --- how a substep begins ------------------------------------------------------------------------


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


# --- one cycle -----------------------------------------------------------------------------------


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
        state: See `space_world.SpaceState`; changed.
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
            solve_contacts(count, mov, body, world, compliance, parts, con, who)
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


# --- many cycles ---------------------------------------------------------------------------------


@compiled
def glide(
    chain: Round,
    centres: Floats,
    place: gliding.Place,
    turns: Ints,
    electronics: gliding.Electronics,
    rows: gliding.RobotRows,
    task: gliding.Task,
    clock: Floats,
    signals: Floats,
    scratch: gliding.Scratch,
    posture: gliding.Posture,
    sees: gliding.Looker,
    taken: gliding.Taken,
    trail: Floats,
) -> None:
    """Let cycles pass until a frame is not quiet, or time is up.

    Args:
        chain: The arguments of :func:`~pirate_sm.simulation.kinematic.space.kernel.advance`.
        centres: Those of the wheels, in the state of the chain.
        place: See `gliding/columns.py`; so for the other groups, `clock` and `signals`.
        turns: Which channels each cycle reads.
        electronics: The boards.
        rows: The robot.
        task: What is watched.
        clock: Changed.
        signals: Changed with each quiet frame.
        scratch: See `goes_on`.
        posture: For the survey of the pipe.
        sees: What a detector looks at.
        taken: Frames are added.
        trail: Where the robot was after each cycle.
    """
    _, rolls, arcs, around = place
    note_places(centres, rolls, clock[gliding.T_CYCLES], trail)
    while may_begin(arcs, around, rows, task, clock, signals, posture, sees, taken):
        advance(*chain)
        note_places(centres, rolls, clock[gliding.T_CYCLES], trail)
        if not goes_on(
            place, turns, electronics, rows, task, clock, signals, scratch, posture, taken
        ):
            break


@compiled
def pass_cycles(
    chain: Round,
    place: gliding.Place,
    turns: Ints,
    sources: Floats,
    counts: Floats,
    rng: Words,
    span: Floats,
) -> None:
    """Let cycles pass with the duties in force, until the surroundings act or all have passed.

    The chain is that of :func:`glide`; the others are the arguments of `passes_on`.
    """
    _, _, _, around = place
    while may_pass(span, around):
        advance(*chain)
        if not passes_on(place, turns, sources, counts, rng, span):
            break
