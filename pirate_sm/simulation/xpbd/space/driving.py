"""The motors of wheels and of the roll joint, and what they turn."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.machine_code import compiled
from pirate_sm.simulation.xpbd.driving import REACHED, strongest
from pirate_sm.simulation.xpbd.space import columns as col


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
        left = con[c, col.TARGET] - rolled - con[c, col.K_SLOPE] * drive
        aside = (
            con[c, col.S_TARGET]
            - _slid(c, i, mov, parts, con, who[c, col.PART])
            - _crept(c, rolled, con)
        )
        tally[i, col.T_DRIVE] += abs(drive) * con[c, col.K_RADIUS]
        tally[i, col.T_GRIP] += drive
        friction = con[c, col.K_MU] * con[c, col.PUSH]
        stalled = con[c, col.K_FORCE] < friction and abs(drive) >= REACHED * con[c, col.K_FORCE]
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
                    wheel[i] -= con[c, col.K_SLOPE] * drive / con[c, col.K_RADIUS]
            else:
                wheel[i] += rolled / con[c, col.K_RADIUS]
    for i in range(n):
        if touch[i] < 0:
            wheel[i] += w[i, col.SPIN]
