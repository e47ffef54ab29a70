"""Compare motions with setpoints as the engine does, in compiled code.

The same operations in the same order give the same bits as
:mod:`pirate_sm.engine.sensing.motion_plausibility`.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.machine_code import compiled


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
    asked: Floats,
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
        duty = abs(asked[int(sensors[m, col.S_SLOT])])
        waits = memory[m, col.M_SAME_S] < np.inf
        driven = duty > sensors[m, col.S_LEAST_DUTY]
        value = numbers[int(sensors[m, col.S_NUMBER])]
        if sensors[m, col.S_LOAD] >= 0.0 and (driven or waits):
            load = abs(numbers[int(sensors[m, col.S_LOAD])])
            if not _bears(m, value, load, duty, now_s, sensors, robot, memory):
                return False
        if duty == 0.0 and settled and not _rests(m, value, since_s, sensors, memory):
            return False
    return True
