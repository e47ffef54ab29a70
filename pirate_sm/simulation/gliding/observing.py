"""Take a frame of a board as the engine does, in compiled code, as long as nothing is unusual.

The same operations in the same order give the same bits as :mod:`pirate_sm.engine.sensing`. A
frame with anything unusual is not taken; the engine takes it then.
"""

from __future__ import annotations

from math import atan2, sin, sqrt

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding.columns import (
    A_ASKED,
    A_ASKED_S,
    A_DRIVING,
    B_CHANNELS,
    B_DERIVED,
    B_SENSORS,
    B_WHEELS,
    C_PLACE,
    C_SCALE,
    C_TARGET,
    C_ZERO,
    D_A,
    D_B,
    D_C,
    D_FACTOR,
    D_KIND,
    D_MORE,
    D_TARGET,
    M_AWAY,
    M_CHANGED,
    M_PROVEN,
    M_REST,
    M_REST_OF_S,
    M_SAME,
    M_SAME_S,
    NORM,
    PITCH,
    R_ODOMETRY,
    R_SETTLE_S,
    R_SILENT_AFTER_S,
    R_SPEED,
    R_STUCK_AFTER_S,
    R_UNLOADED,
    RATE,
    ROLL,
    S_FULL_LOAD,
    S_HIGH,
    S_LEAST_DUTY,
    S_LOAD,
    S_LOW,
    S_MOVED,
    S_NUMBER,
    S_RATE,
    S_SLACK,
    S_SLOT,
    TORQUE,
    V_ASKED,
    V_DRIVEN,
    V_FORCE,
    W_ANGLE,
    W_BOARD,
    W_METRES,
    W_PLACE,
    W_SLOT,
    W_SPEED,
)
from pirate_sm.simulation.machine_code import compiled


@compiled
def convert(board: Ints, channels: Floats, values: Floats, numbers: Floats) -> bool:
    """Write what a board measures to `numbers`, SI; return whether every value is known."""
    known = True
    for c in range(board[B_CHANNELS], board[B_CHANNELS + 1]):
        target = int(channels[c, C_TARGET])
        numbers[target] = values[int(channels[c, C_PLACE])] * channels[c, C_SCALE]
        numbers[target] -= channels[c, C_ZERO]
        known = known and not np.isnan(numbers[target])
    return known


@compiled
def is_plausible(
    board: Ints, sensors: Floats, numbers: Floats, before: Floats, elapsed_s: float
) -> bool:
    """Return whether every sensor is in its range and near its value before."""
    for m in range(board[B_SENSORS], board[B_SENSORS + 1]):
        number = int(sensors[m, S_NUMBER])
        value = numbers[number]
        if sensors[m, S_HIGH] < np.inf and not (sensors[m, S_LOW] <= value <= sensors[m, S_HIGH]):
            return False
        reach = sensors[m, S_RATE] * elapsed_s + sensors[m, S_SLACK]
        if sensors[m, S_RATE] < np.inf and not abs(value - before[number]) <= reach:
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
    free = duty > sensors[m, S_LEAST_DUTY]
    free = free and load < robot[R_UNLOADED] * duty * sensors[m, S_FULL_LOAD]
    if not free:
        if memory[m, M_SAME_S] != np.inf:
            memory[m, M_SAME_S] = np.inf
            memory[m, M_CHANGED] = 1.0
        return True
    if memory[m, M_SAME_S] == np.inf or value != memory[m, M_SAME]:
        memory[m, M_SAME] = value
        memory[m, M_SAME_S] = now_s
        memory[m, M_CHANGED] = 1.0
        return True
    return bool(now_s - memory[m, M_SAME_S] < robot[R_STUCK_AFTER_S])


@compiled
def _rests(m: int, value: float, since_s: float, sensors: Floats, memory: Floats) -> bool:
    """Remember where a sensor rests; return whether it has not left that place."""
    if memory[m, M_REST_OF_S] != since_s:
        memory[m, M_REST] = value
        memory[m, M_REST_OF_S] = since_s
        memory[m, M_PROVEN] = 0.0
        memory[m, M_AWAY] = 0.0
        memory[m, M_CHANGED] = 1.0
        return True
    if not abs(value - memory[m, M_REST]) <= sensors[m, S_MOVED]:
        return False
    if memory[m, M_PROVEN] == 0.0 or memory[m, M_AWAY] != 0.0:
        memory[m, M_PROVEN] = 1.0
        memory[m, M_AWAY] = 0.0
        memory[m, M_CHANGED] = 1.0
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
    if watch[A_ASKED] == 0.0:
        return True
    since_s = watch[A_ASKED_S]
    settled = watch[A_DRIVING] == 0.0 and now_s - since_s >= robot[R_SETTLE_S]
    for m in range(board[B_SENSORS], board[B_SENSORS + 1]):
        if not sensors[m, S_MOVED] < np.inf:
            continue
        duty = abs(slots[int(sensors[m, S_SLOT]), V_ASKED])
        waits = memory[m, M_SAME_S] < np.inf
        asked = duty > sensors[m, S_LEAST_DUTY]
        value = numbers[int(sensors[m, S_NUMBER])]
        if sensors[m, S_LOAD] >= 0.0 and (asked or waits):
            load = abs(numbers[int(sensors[m, S_LOAD])])
            if not _bears(m, value, load, duty, now_s, sensors, robot, memory):
                return False
        if duty == 0.0 and settled and not _rests(m, value, since_s, sensors, memory):
            return False
    return True


@compiled
def _vector(kind: int, x: float, y: float, z: float) -> float:
    if kind == NORM:
        return sqrt(x * x + y * y + z * z)
    if np.isnan(x) or np.isnan(y) or np.isnan(z):
        return np.nan
    return atan2(-y, z) if kind == ROLL else atan2(x, sqrt(y * y + z * z))


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
    for d in range(board[B_DERIVED], board[B_DERIVED + 1]):
        kind = int(derived[d, D_KIND])
        a, b = int(derived[d, D_A]), int(derived[d, D_B])
        target = int(derived[d, D_TARGET])
        if kind == RATE:
            numbers[target] = (numbers[a] - before[a]) / elapsed_s
        elif kind == TORQUE:
            setpoint = slots[b, V_FORCE]
            sign = 0.0 if setpoint == 0.0 else (1.0 if setpoint > 0.0 else -1.0)
            numbers[target] = numbers[a] * derived[d, D_FACTOR] * sign
        elif kind in (ROLL, PITCH, NORM):
            c = int(derived[d, D_C])
            numbers[target] = _vector(kind, numbers[a], numbers[b], numbers[c])
        else:
            angle = numbers[a] if np.isfinite(numbers[a]) else np.nan
            numbers[target] = abs(derived[d, D_FACTOR] * sin(angle / 2)) + derived[d, D_MORE]


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
        driven = slots[int(wheels[k, W_SLOT]), V_DRIVEN] != 0.0
        if driven and not np.isnan(angles[int(wheels[k, W_PLACE])]):
            board = int(wheels[k, W_BOARD])
            if board == position or heard_s[board] > limit_s:
                count += 1
    return count


@compiled
def _speed(wheels: Floats, slots: Floats, numbers: Floats) -> float:
    """Return the mean speed of the measured driven wheels, or of all wheels if none is driven."""
    known, total, every, sum_ = 0, 0.0, 0, 0.0
    for k in range(wheels.shape[0]):
        speed = numbers[int(wheels[k, W_SPEED])] * wheels[k, W_METRES]
        if np.isnan(speed):
            continue
        every += 1
        sum_ += speed
        if slots[int(wheels[k, W_SLOT]), V_DRIVEN] != 0.0:
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
    if board[B_WHEELS] == board[B_WHEELS + 1]:
        return
    silent_s = robot[R_SILENT_AFTER_S]
    silence_s = now_s - heard_s[position]
    part = min(1.0, silent_s / silence_s) if silence_s > 0.0 else 1.0
    driven = False
    for k in range(board[B_WHEELS], board[B_WHEELS + 1]):
        angles[int(own[k, W_PLACE])] = numbers[int(own[k, W_ANGLE])]
        driven = driven or slots[int(own[k, W_SLOT]), V_DRIVEN] != 0.0
    sharing = 0
    if driven:
        sharing = _sharing(position, now_s - silent_s, wheels, slots, heard_s, angles)
    odometry = int(robot[R_ODOMETRY])
    for k in range(board[B_WHEELS], board[B_WHEELS + 1]):
        place = int(own[k, W_PLACE])
        share = 0.0
        if sharing > 0 and slots[int(own[k, W_SLOT]), V_DRIVEN] != 0.0:
            share = 1.0 / sharing
        old = shares[place] if shares[place] != 0.0 else share
        shares[place] = share
        turned = angles[place] - before[place]
        if odometry >= 0 and not np.isnan(turned):
            numbers[odometry] += turned * own[k, W_METRES] * old * part
    if int(robot[R_SPEED]) >= 0:
        numbers[int(robot[R_SPEED])] = _speed(wheels, slots, numbers)
