"""Decide whether a frame changes nothing but signals, in compiled code."""

from __future__ import annotations

import numpy as np

from pirate_sm.core.sensing import evaluator
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.groups import Posture, RobotRows, Scratch, Task
from pirate_sm.simulation.gliding.listening import listen, may_listen
from pirate_sm.simulation.gliding.machine import value_of
from pirate_sm.simulation.gliding.surveying import survey
from pirate_sm.simulation.machine_code import compiled, compiled_module

run = compiled_module(evaluator)["run"]

_IN_TIME = 1.5
"""Periods within which a board must report, else reports have been lost."""


@compiled
def holds_as_before(
    position: int, conditions: Ints, code: Floats, numbers: Floats, origin: Floats, stack: Floats
) -> bool:
    """Return whether every condition of a board is as it was."""
    for k in range(conditions.shape[0]):
        if (conditions[k, col.K_BOARDS] >> position) & 1 == 0:
            continue
        begin, end = conditions[k, col.K_BEGIN], conditions[k, col.K_END]
        value = value_of(code, begin, end, numbers, origin, stack)
        if (value == 1.0) != (conditions[k, col.K_HOLDS] == 1):
            return False
    return True


@compiled
def asks_the_same(duties: Floats, numbers: Floats, loss: float) -> bool:
    """Return whether every position loop gives the duty that was sent last.

    See ``RunningPositionLoop`` in ``core/_engine/control/position_loop.py``.
    """
    for p in range(duties.shape[0]):
        error = duties[p, col.P_TARGET] - numbers[int(duties[p, col.P_ANGLE])]
        duty = 0.0
        if abs(error) > duties[p, col.P_THRESHOLD]:
            size = max(abs(error) * duties[p, col.P_GAIN] * (1.0 - loss), duties[p, col.P_LEAST])
            size = min(size, duties[p, col.P_LIMIT])
            duty = size if error > 0.0 else -size
        resolution = duties[p, col.P_RESOLUTION]
        if np.rint(duty / resolution) * resolution != duties[p, col.P_SENT]:
            return False
    return True


@compiled
def _is_known(measured: Ints, numbers: Floats) -> bool:
    """Return whether every signal that these rows measure is known."""
    known = True
    for k in range(measured.shape[0]):
        known = known and not np.isnan(numbers[measured[k, 1]])
    return known


@compiled
def _copy(some: Floats, to: Floats) -> None:
    for k in range(some.shape[0]):
        to[k] = some[k]


@compiled
def looks_round(now_s: float, numbers: Floats, posture: Posture) -> bool:
    """Survey the pipe if that is due; return whether there is nothing to report."""
    chain, parts, body, held, surveyed = posture
    if now_s < surveyed[0, col.E_DUE_S]:
        return True
    _copy(surveyed[0], surveyed[1])
    if not survey(now_s, numbers, chain, parts, body, held, surveyed[1]):
        return False
    _copy(surveyed[1], surveyed[0])
    return True


@compiled
def take_frame(
    position: int,
    values: Floats,
    rows: RobotRows,
    task: Task,
    clock: Floats,
    signals: Floats,
    scratch: Scratch,
    posture: Posture,
    ticks: Floats,
    met: Ints,
) -> bool:
    """Take a frame if it changes nothing but signals; otherwise leave everything as it is.

    Silent boards are looked for where that is due at its time.
    `values` are the raw values of the frame of the board at `position`; the other arguments are
    those of :func:`~pirate_sm.simulation.gliding.cycle.goes_on`.
    """
    boards, table, lists, robot = rows
    conditions, code, origin, duties, watch = task
    fresh, stack = scratch
    now_s, count = clock[col.T_NOW_S], origin.shape[0]
    heard_end = count + boards.shape[0]
    elapsed_s = max(now_s - signals[count + position], robot[col.R_PERIOD_S])
    listens = now_s >= clock[col.T_LISTENING_S]
    due_s = watch[col.A_ALARM_S] if listens else min(watch[col.A_ALARM_S], clock[col.T_LISTENING_S])
    deadline_s = min(watch[col.A_FRAMES_S], due_s - col.TOLERANCE_S)
    if now_s >= deadline_s or elapsed_s > _IN_TIME * robot[col.R_PERIOD_S]:
        return False
    board = boards[position]
    _copy(signals, fresh)
    numbers = fresh[:count]
    own = table[board[col.B_BEGIN] : board[col.B_END]]
    measured = table[board[col.B_BEGIN] : board[col.B_MEASURED]]
    kept = run(own, lists, fresh, signals, values, now_s, elapsed_s)
    if not (kept and _is_known(measured, numbers)):
        return False
    quiet = asks_the_same(duties, numbers, fresh[int(robot[col.R_LOSS])])
    quiet = quiet and holds_as_before(position, conditions, code, numbers, origin, stack)
    if listens and not may_listen(now_s, fresh[count:heard_end], robot, watch, ticks, met):
        return False
    if not (quiet and looks_round(now_s, numbers, posture)):
        return False
    if listens:
        listen(now_s, 1.0, robot, watch, clock, ticks, met)
    _copy(fresh, signals)
    return True
