"""Take a frame of a board as the engine does, in compiled code, as long as nothing is unusual.

The same operations in the same order give the same bits as :mod:`pirate_sm.engine.sensing`. A
frame with anything unusual is not taken; the engine takes it then.
"""

from __future__ import annotations

from math import atan2, sin, sqrt

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.machine_code import compiled


@compiled
def convert(board: Ints, channels: Floats, values: Floats, numbers: Floats) -> bool:
    """Write what a board measures to `numbers`, SI; return whether every value is known."""
    known = True
    for c in range(board[col.B_CHANNELS], board[col.B_CHANNELS + 1]):
        target = int(channels[c, col.C_TARGET])
        numbers[target] = values[int(channels[c, col.C_PLACE])] * channels[c, col.C_SCALE]
        numbers[target] -= channels[c, col.C_ZERO]
        known = known and not np.isnan(numbers[target])
    return known


@compiled
def is_plausible(
    board: Ints, sensors: Floats, numbers: Floats, before: Floats, elapsed_s: float
) -> bool:
    """Return whether every sensor is in its range and near its value before."""
    for m in range(board[col.B_SENSORS], board[col.B_SENSORS + 1]):
        number = int(sensors[m, col.S_NUMBER])
        value = numbers[number]
        if sensors[m, col.S_HIGH] < np.inf and not (
            sensors[m, col.S_LOW] <= value <= sensors[m, col.S_HIGH]
        ):
            return False
        reach = sensors[m, col.S_RATE] * elapsed_s + sensors[m, col.S_SLACK]
        if sensors[m, col.S_RATE] < np.inf and not abs(value - before[number]) <= reach:
            return False
    return True


@compiled
def _bears(
    m: int,
    value: float,
    load: float,
    duty: float,
    now_s: float,
    sensors: Floats,
    robot: Floats,
    memory: Floats,
) -> bool:
    """Remember how long a driven motor shows no motion; return whether that is not too long."""
    free = duty > sensors[m, col.S_LEAST_DUTY]
    free = free and load < robot[col.R_UNLOADED] * duty * sensors[m, col.S_FULL_LOAD]
    if not free:
        if memory[m, col.M_SAME_S] != np.inf:
            memory[m, col.M_SAME_S] = np.inf
            memory[m, col.M_CHANGED] = 1.0
        return True
    if memory[m, col.M_SAME_S] == np.inf or value != memory[m, col.M_SAME]:
        memory[m, col.M_SAME] = value
        memory[m, col.M_SAME_S] = now_s
        memory[m, col.M_CHANGED] = 1.0
        return True
    return bool(now_s - memory[m, col.M_SAME_S] < robot[col.R_STUCK_AFTER_S])


@compiled
def _rests(m: int, value: float, since_s: float, sensors: Floats, memory: Floats) -> bool:
    """Remember where a sensor rests; return whether it has not left that place."""
    if memory[m, col.M_REST_OF_S] != since_s:
        memory[m, col.M_REST] = value
        memory[m, col.M_REST_OF_S] = since_s
        memory[m, col.M_PROVEN] = 0.0
        memory[m, col.M_AWAY] = 0.0
        memory[m, col.M_CHANGED] = 1.0
        return True
    if not abs(value - memory[m, col.M_REST]) <= sensors[m, col.S_MOVED]:
        return False
    if memory[m, col.M_PROVEN] == 0.0 or memory[m, col.M_AWAY] != 0.0:
        memory[m, col.M_PROVEN] = 1.0
        memory[m, col.M_AWAY] = 0.0
        memory[m, col.M_CHANGED] = 1.0
    return True


@compiled
def moves_as_asked(
    board: Ints,
    now_s: float,
    sensors: Floats,
    robot: Floats,
    slots: Floats,
    watch: Floats,
    numbers: Floats,
    memory: Floats,
) -> bool:
    """Return whether no sensor shows a motion, or a lack of one, that its motor contradicts.

    See :mod:`pirate_sm.engine.sensing.motion_plausibility`.
    """
    if watch[col.A_ASKED] == 0.0:
        return True
    since_s = watch[col.A_ASKED_S]
    settled = watch[col.A_DRIVING] == 0.0 and now_s - since_s >= robot[col.R_SETTLE_S]
    for m in range(board[col.B_SENSORS], board[col.B_SENSORS + 1]):
        if not sensors[m, col.S_MOVED] < np.inf:
            continue
        duty = abs(slots[int(sensors[m, col.S_SLOT]), col.V_ASKED])
        waits = memory[m, col.M_SAME_S] < np.inf
        asked = duty > sensors[m, col.S_LEAST_DUTY]
        value = numbers[int(sensors[m, col.S_NUMBER])]
        if sensors[m, col.S_LOAD] >= 0.0 and (asked or waits):
            load = abs(numbers[int(sensors[m, col.S_LOAD])])
            if not _bears(m, value, load, duty, now_s, sensors, robot, memory):
                return False
        if duty == 0.0 and settled and not _rests(m, value, since_s, sensors, memory):
            return False
    return True


@compiled
def _vector(kind: int, x: float, y: float, z: float) -> float:
    if kind == col.NORM:
        return sqrt(x * x + y * y + z * z)
    if np.isnan(x) or np.isnan(y) or np.isnan(z):
        return np.nan
    return atan2(-y, z) if kind == col.ROLL else atan2(x, sqrt(y * y + z * z))


@compiled
def derive(
    board: Ints,
    derived: Floats,
    slots: Floats,
    numbers: Floats,
    before: Floats,
    elapsed_s: float,
) -> None:
    """Write rates, torques, vectors and diameters that follow from a board's values."""
    for d in range(board[col.B_DERIVED], board[col.B_DERIVED + 1]):
        kind = int(derived[d, col.D_KIND])
        a, b = int(derived[d, col.D_A]), int(derived[d, col.D_B])
        target = int(derived[d, col.D_TARGET])
        if kind == col.RATE:
            numbers[target] = (numbers[a] - before[a]) / elapsed_s
        elif kind == col.TORQUE:
            setpoint = slots[b, col.V_FORCE]
            sign = 0.0 if setpoint == 0.0 else (1.0 if setpoint > 0.0 else -1.0)
            numbers[target] = numbers[a] * derived[d, col.D_FACTOR] * sign
        elif kind in (col.ROLL, col.PITCH, col.NORM):
            c = int(derived[d, col.D_C])
            numbers[target] = _vector(kind, numbers[a], numbers[b], numbers[c])
        else:
            angle = numbers[a] if np.isfinite(numbers[a]) else np.nan
            numbers[target] = (
                abs(derived[d, col.D_FACTOR] * sin(angle / 2)) + derived[d, col.D_MORE]
            )


@compiled
def _sharing(
    position: int,
    limit_s: float,
    wheels: Floats,
    slots: Floats,
    heard_s: Floats,
    angles: Floats,
) -> int:
    """Return how many driven, measured wheels share in the odometry."""
    count = 0
    for k in range(wheels.shape[0]):
        driven = slots[int(wheels[k, col.W_SLOT]), col.V_DRIVEN] != 0.0
        if driven and not np.isnan(angles[int(wheels[k, col.W_PLACE])]):
            board = int(wheels[k, col.W_BOARD])
            if board == position or heard_s[board] > limit_s:
                count += 1
    return count


@compiled
def _speed(wheels: Floats, slots: Floats, numbers: Floats) -> float:
    """Return the mean speed of the measured driven wheels, or of all wheels if none is driven."""
    known, total, every, sum_ = 0, 0.0, 0, 0.0
    for k in range(wheels.shape[0]):
        speed = numbers[int(wheels[k, col.W_SPEED])] * wheels[k, col.W_METRES]
        if np.isnan(speed):
            continue
        every += 1
        sum_ += speed
        if slots[int(wheels[k, col.W_SLOT]), col.V_DRIVEN] != 0.0:
            known += 1
            total += speed
    if known > 0:
        return total / known
    return sum_ / every if every > 0 else np.nan


@compiled
def roll_on(
    position: int,
    board: Ints,
    now_s: float,
    wheels: Floats,
    own: Floats,
    robot: Floats,
    slots: Floats,
    numbers: Floats,
    heard_s: Floats,
    shares: Floats,
    before: Floats,
    angles: Floats,
) -> None:
    """Update odometry and speed with a board's wheels; see :mod:`pirate_sm.engine.sensing`.

    The board is `boards[position]`; `before` are the angles before its frame.
    """
    if board[col.B_WHEELS] == board[col.B_WHEELS + 1]:
        return
    silent_s = robot[col.R_SILENT_AFTER_S]
    silence_s = now_s - heard_s[position]
    part = min(1.0, silent_s / silence_s) if silence_s > 0.0 else 1.0
    driven = False
    for k in range(board[col.B_WHEELS], board[col.B_WHEELS + 1]):
        angles[int(own[k, col.W_PLACE])] = numbers[int(own[k, col.W_ANGLE])]
        driven = driven or slots[int(own[k, col.W_SLOT]), col.V_DRIVEN] != 0.0
    sharing = 0
    if driven:
        sharing = _sharing(position, now_s - silent_s, wheels, slots, heard_s, angles)
    odometry = int(robot[col.R_ODOMETRY])
    for k in range(board[col.B_WHEELS], board[col.B_WHEELS + 1]):
        place = int(own[k, col.W_PLACE])
        share = 0.0
        if sharing > 0 and slots[int(own[k, col.W_SLOT]), col.V_DRIVEN] != 0.0:
            share = 1.0 / sharing
        old = shares[place] if shares[place] != 0.0 else share
        shares[place] = share
        turned = angles[place] - before[place]
        if odometry >= 0 and not np.isnan(turned):
            numbers[odometry] += turned * own[k, col.W_METRES] * old * part
    if int(robot[col.R_SPEED]) >= 0:
        numbers[int(robot[col.R_SPEED])] = _speed(wheels, slots, numbers)
