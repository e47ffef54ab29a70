"""The compiled part of the kinematic simulator: extended position-based dynamics in a plane.

Python calls :func:`advance` and, for many cycles, :func:`glide` and :func:`pass_cycles`; their
machine code is built with the package (`simulation/machine_code`). The other modules of this folder
hold functions that they call, and `columns.py` the names of the columns of their arrays.

A substep is: motors, predict, iterate (joints, contacts, corners, links), velocity from
displacement (XPBD, Macklin et al. 2016). Gradients are those at the start of the substep, since
nothing turns by more than a few mrad in one; a coarser computation keeps them, and what touches
what, for some substeps. Impulses are in kg m, that is force times the squared step.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints, Words
from pirate_sm.simulation.gliding import columns as gliding
from pirate_sm.simulation.gliding.cycle import goes_on, may_begin, may_pass, note_places, passes_on
from pirate_sm.simulation.kinematic import columns as col
from pirate_sm.simulation.kinematic.contacts import (
    aim,
    clear,
    find_contacts,
    find_corners,
    prepare_contacts,
    solve_contacts,
    solve_corners,
)
from pirate_sm.simulation.kinematic.joints_and_motors import (
    lies,
    prepare_motors,
    solve_joints,
    solve_links,
    turn_motor,
    turn_roll,
    turn_wheels,
    turned_rad,
)
from pirate_sm.simulation.machine_code import compiled

# --- how a call and a substep begin --------------------------------------------------------------


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


# --- what is measured ----------------------------------------------------------------------------


@compiled
def project(n: int, pos: Floats, legs: Floats, out: Floats) -> None:
    """Write arc length, offset towards side A and leg of each wheel to their blocks of `out`."""
    side = col.OUT_PER_WHEEL * n + col.OUT_SINGLE
    for i in range(n):
        best = np.inf
        for k in range(legs.shape[0]):
            dx = pos[i, 0] - legs[k, col.L_X]
            dy = pos[i, 1] - legs[k, col.L_Y]
            along = dx * legs[k, col.L_TX] + dy * legs[k, col.L_TY]
            across = dy * legs[k, col.L_TX] - dx * legs[k, col.L_TY]
            # The first and the last leg continue beyond the pipe's open ends.
            if k > 0:
                along = max(along, 0.0)
            if k < legs.shape[0] - 1:
                along = min(along, legs[k, col.L_LENGTH])
            ax = dx - along * legs[k, col.L_TX]
            ay = dy - along * legs[k, col.L_TY]
            away2 = ax * ax + ay * ay
            if away2 < best:
                best = away2
                out[7 * n + i] = legs[k, col.L_S] + along
                out[side + i] = across
                out[side + n + i] = k


@compiled
def feel(
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
    pipe lies flat and the part has roll 0. In free fall the specific force is zero; what is
    shown of it is averaged.
    """
    k = col.OUT_PER_WHEEL * n
    m = min(max(int(world[col.ROLL_LINK]), 0), n - 2)
    leg = legs[int(out[(col.OUT_PER_WHEEL + 1) * n + col.OUT_SINGLE + m])]
    hx = pos[m, 0] - pos[m + 1, 0]
    hy = pos[m, 1] - pos[m + 1, 1]
    length = np.sqrt(hx * hx + hy * hy)
    hx /= length
    hy /= length
    cr = np.cos(roll[1])
    sr = np.sin(roll[1])
    across = leg[col.L_GN] if roll[1] == 0.0 else leg[col.L_GN] * cr - leg[col.L_GB] * sr
    fx = accel_x - (leg[col.L_GT] * leg[col.L_TX] - across * leg[col.L_TY])
    fy = accel_y - (leg[col.L_GT] * leg[col.L_TY] + across * leg[col.L_TX])
    share = world[col.FELT]
    out[k + 2] += share * (fx * hx + fy * hy - out[k + 2])
    out[k + 3] += share * (fx * hy - fy * hx - out[k + 3])
    out[k + 4] += share * (leg[col.L_GN] * sr + leg[col.L_GB] * cr - out[k + 4])
    sideways = world[col.MAG_X] * hy - world[col.MAG_Y] * hx
    out[k + 5] = world[col.MAG_X] * hx + world[col.MAG_Y] * hy
    out[k + 6] = sideways * cr - world[col.MAG_Z] * sr
    out[k + 7] = sideways * sr + world[col.MAG_Z] * cr


# --- one cycle -----------------------------------------------------------------------------------


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
            solve_contacts(count, pos, body, world, compliance, w, con, who)
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


# --- many cycles ---------------------------------------------------------------------------------


@compiled
def glide(
    chain: Bars,
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
        chain: The arguments of :func:`~pirate_sm.simulation.kinematic.kernel.advance`.
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
    chain: Bars,
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
