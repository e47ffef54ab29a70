"""Decide whether a frame changes nothing but signals, in compiled code."""

from __future__ import annotations

import numpy as np

from pirate_sm.core.sensing import evaluator
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.columns import Posture, RobotRows, Scratch, Task
from pirate_sm.simulation.gliding.surveying import survey
from pirate_sm.simulation.machine_code import compiled, compiled_module

# --- conditions ----------------------------------------------------------------------------------


# The instructions, as in `core/_expressions/compiler.py`: numbers, which numba takes as constants.
CONSTANT, NUMBER, NEGATE, ABSOLUTE, KNOWN, NOT, ADD, SUBTRACT, MULTIPLY, DIVIDE = range(10)
EQUAL, DIFFERENT, LESS, AT_MOST, GREATER, AT_LEAST, LEAST, GREATEST, ALL, ANY = range(10, 20)

# Columns of the code.
OPERATION, ARGUMENT = range(2)


@compiled
def _compared(operation: int, left: float, right: float) -> float:
    if np.isnan(left) or np.isnan(right):
        return np.nan
    if operation == EQUAL:
        holds = left == right
    elif operation == DIFFERENT:
        holds = left != right
    elif operation == LESS:
        holds = left < right
    elif operation == AT_MOST:
        holds = left <= right
    elif operation == GREATER:
        holds = left > right
    else:
        holds = left >= right
    return 1.0 if holds else 0.0


@compiled
def _calculated(operation: int, left: float, right: float) -> float:
    if operation == ADD:
        return left + right
    if operation == SUBTRACT:
        return left - right
    if operation == MULTIPLY:
        return left * right
    return left / right if right != 0.0 else np.nan


@compiled
def _changed(operation: int, value: float) -> float:
    if operation == KNOWN:
        return 0.0 if np.isnan(value) else 1.0
    if operation == NEGATE:
        return -value
    if operation == ABSOLUTE:
        return abs(value)
    return np.nan if np.isnan(value) else 1.0 - value


@compiled
def _joined(operation: int, values: Floats) -> float:
    """Return the least, the greatest, or whether all or any of several values are true."""
    deciding = 0.0 if operation == ALL else 1.0
    result = values[0]
    unknown = False
    for value in values:
        unknown = unknown or np.isnan(value)
        if operation == LEAST:
            result = value if value < result else result
        elif operation == GREATEST:
            result = value if value > result else result
        elif value == deciding:
            return deciding
    if unknown:
        return np.nan
    return result if operation < ALL else 1.0 - deciding


@compiled
def value_of(
    code: Floats, begin: int, end: int, numbers: Floats, origin: Floats, stack: Floats
) -> float:
    """Return the value of a condition: 1 true, 0 false, NaN unknown; or that of a number.

    Args:
        code: `(instructions, 2)`: operation and argument.
        begin: The first instruction.
        end: The instruction after the last.
        numbers: Signals, SI; NaN is unknown.
        origin: Signals when the wait began; the change of a signal has its index after all signals.
        stack: Scratch; as deep as the code needs.
    """
    count = numbers.shape[0]
    top = -1
    for at in range(begin, end):
        operation = int(code[at, OPERATION])
        if operation == CONSTANT:
            top += 1
            stack[top] = code[at, ARGUMENT]
        elif operation == NUMBER:
            top += 1
            index = int(code[at, ARGUMENT])
            if index < count:
                stack[top] = numbers[index]
            else:
                stack[top] = numbers[index - count] - origin[index - count]
        elif operation < ADD:
            stack[top] = _changed(operation, stack[top])
        elif operation < EQUAL:
            top -= 1
            stack[top] = _calculated(operation, stack[top], stack[top + 1])
        elif operation < LEAST:
            top -= 1
            stack[top] = _compared(operation, stack[top], stack[top + 1])
        else:
            top -= int(code[at, ARGUMENT]) - 1
            stack[top] = _joined(operation, stack[top : top + int(code[at, ARGUMENT])])
    return float(stack[0])


# --- silent boards -------------------------------------------------------------------------------


@compiled
def may_listen(
    now_s: float, heard_s: Floats, robot: Floats, watch: Floats, ticks: Floats, met: Ints
) -> bool:
    """Return whether every board has reported lately, and nothing else is due.

    If not, the engine has to look. `heard_s` tells when each board last reported; see
    :mod:`pirate_sm.core.robot`.
    """
    if met[col.N_TICKS] == ticks.shape[0] or heard_s.shape[0] == 0:
        return False
    if now_s >= watch[col.A_ALARM_S] - col.TOLERANCE_S:
        return False
    newest_s = heard_s[0]
    for at_s in heard_s:
        newest_s = max(newest_s, at_s)
        if (
            at_s <= now_s - robot[col.R_STALE_AFTER_S]
            or at_s <= now_s - robot[col.R_SILENT_AFTER_S]
        ):
            return False
    return bool(newest_s > now_s - robot[col.R_SILENT_AFTER_S] / 2)


@compiled
def listen(
    now_s: float,
    of_frame: float,
    robot: Floats,
    watch: Floats,
    clock: Floats,
    ticks: Floats,
    met: Ints,
) -> None:
    """Note that every board has reported. See `columns.py` for the arrays."""
    made = met[col.N_TICKS]
    clock[col.T_CHECKED_S] = now_s
    clock[col.T_LISTENING_S] = now_s + robot[col.R_LISTEN_EVERY_S]
    ticks[made, col.J_AT_S] = now_s
    ticks[made, col.J_WAKE_S] = min(watch[col.A_ALARM_S], clock[col.T_LISTENING_S])
    ticks[made, col.J_OF_FRAME] = of_frame
    met[col.N_TICKS] = made + 1


# --- frames --------------------------------------------------------------------------------------


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

    See ``RunningPositionLoop`` in ``core/_engine/robot/loops.py``.
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
