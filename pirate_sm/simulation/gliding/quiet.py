"""Decide whether a frame changes nothing but signals, in compiled code."""

from __future__ import annotations

import numpy as np

from pirate_sm.core.expressions import machine
from pirate_sm.core.robot import duty_cycles
from pirate_sm.core.sensing import evaluator, surveyor
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.columns import Posture, RobotRows, Scratch, Task
from pirate_sm.simulation.machine_code import compiled, compiled_module

run = compiled_module(evaluator)["run"]
value_of = compiled_module(machine)["value_of"]
_duties, _surveyor = compiled_module(duty_cycles), compiled_module(surveyor)
position_duty, quantised = _duties["position_duty"], _duties["quantised"]
survey, is_news, _DUE_S = _surveyor["survey"], _surveyor["is_news"], surveyor.DUE_S

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
    oldest_s = now_s
    for at_s in heard_s:
        oldest_s = min(oldest_s, at_s)
    return bool(oldest_s > now_s - robot[col.R_SILENT_S])


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
    """Return whether every position loop gives the duty that was sent last."""
    for loop in duties:
        error = loop[col.P_TARGET] - numbers[int(loop[col.P_ANGLE])]
        gain, threshold, least = loop[col.P_GAIN], loop[col.P_THRESHOLD], loop[col.P_LEAST]
        duty = position_duty(error, loss, gain, threshold, least, loop[col.P_LIMIT])
        if quantised(duty, loop[col.P_RESOLUTION]) != loop[col.P_SENT]:
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
def looks_round(now_s: float, numbers: Floats, watch: Floats, posture: Posture) -> bool:
    """Survey the pipe if that is due; return whether there is nothing to report."""
    chain, parts, imu, memory = posture
    if now_s < memory[0, _DUE_S]:
        return True
    if now_s >= watch[col.A_OUTSIDE_S] - col.TOLERANCE_S:
        return False
    _copy(memory[0], memory[1])
    survey(now_s, numbers, chain, parts, imu, memory[1])
    if is_news(memory[1]):
        return False
    _copy(memory[1], memory[0])
    memory[0, _DUE_S] = min(memory[0, _DUE_S], watch[col.A_OUTSIDE_S])
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
    if now_s >= deadline_s:
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
    if not (quiet and looks_round(now_s, numbers, watch, posture)):
        return False
    if listens:
        listen(now_s, 1.0, robot, watch, clock, ticks, met)
    _copy(fresh, signals)
    return True
