"""Decide whether a frame changes nothing but signals, in compiled code."""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding.columns import (
    A_DEADLINE_S,
    E_DUE_S,
    K_BEGIN,
    K_BOARDS,
    K_END,
    K_HOLDS,
    P_ANGLE,
    P_GAIN,
    P_LEAST,
    P_LIMIT,
    P_RESOLUTION,
    P_SENT,
    P_TARGET,
    P_THRESHOLD,
    R_LOSS_GAIN,
    R_PERIOD_S,
    T_LOSS,
)
from pirate_sm.simulation.gliding.machine import value_of
from pirate_sm.simulation.gliding.observing import (
    convert,
    derive,
    is_plausible,
    moves_as_asked,
    roll_on,
)
from pirate_sm.simulation.gliding.surveying import survey
from pirate_sm.simulation.machine_code import compiled

_IN_TIME = 1.5
"""Periods within which a board must report, else reports have been lost."""


@compiled
def holds_as_before(
    position: int,
    conditions: Ints,
    code: Floats,
    numbers: Floats,
    origin: Floats,
    stack: Floats,
) -> bool:
    """Return whether every condition of a board is as it was."""
    for k in range(conditions.shape[0]):
        if (conditions[k, K_BOARDS] >> position) & 1 == 0:
            continue
        begin, end = conditions[k, K_BEGIN], conditions[k, K_END]
        value = value_of(code, begin, end, numbers, origin, stack)
        if (value == 1.0) != (conditions[k, K_HOLDS] == 1):
            return False
    return True


@compiled
def asks_the_same(duties: Floats, numbers: Floats, loss: float) -> bool:
    """Return whether every position loop gives the duty that was sent last.

    See :class:`pirate_sm.engine.control.position_loop.PositionLoop`.
    """
    for p in range(duties.shape[0]):
        error = duties[p, P_TARGET] - numbers[int(duties[p, P_ANGLE])]
        duty = 0.0
        if abs(error) > duties[p, P_THRESHOLD]:
            size = max(abs(error) * duties[p, P_GAIN] * (1.0 - loss), duties[p, P_LEAST])
            size = min(size, duties[p, P_LIMIT])
            duty = size if error > 0.0 else -size
        resolution = duties[p, P_RESOLUTION]
        if np.rint(duty / resolution) * resolution != duties[p, P_SENT]:
            return False
    return True


@compiled
def take_frame(
    position: int,
    now_s: float,
    values: Floats,
    boards: Ints,
    channels: Floats,
    derived: Floats,
    wheels: Floats,
    own: Floats,
    sensors: Floats,
    robot: Floats,
    slots: Floats,
    conditions: Ints,
    code: Floats,
    origin: Floats,
    duties: Floats,
    watch: Floats,
    clock: Floats,
    numbers: Floats,
    heard_s: Floats,
    shares: Floats,
    angles: Floats,
    memory: Floats,
    fresh: Floats,
    turned: Floats,
    stack: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
    held: Ints,
    surveyed: Floats,
    forces: Floats,
    sorted_: Floats,
) -> bool:
    """Take a frame if it changes nothing but signals; otherwise leave everything as it is.

    The frame of `boards[position]` was received at `now_s`; `values` are its raw values. `fresh`,
    as long as `numbers`, `turned`, as long as `angles`, `stack` and `sorted_` are scratch. The
    other arrays are described in :mod:`pirate_sm.simulation.gliding.columns`.
    """
    elapsed_s = max(now_s - heard_s[position], robot[R_PERIOD_S])
    if now_s >= watch[A_DEADLINE_S] or elapsed_s > _IN_TIME * robot[R_PERIOD_S]:
        return False
    board = boards[position]
    fresh[:] = numbers
    if not convert(board, channels, values, fresh):
        return False
    if not is_plausible(board, sensors, fresh, numbers, elapsed_s):
        return False
    kept = memory.copy()
    kept_shares = shares.copy()
    kept_angles = angles.copy()
    quiet = moves_as_asked(board, now_s, sensors, robot, slots, watch, fresh, memory)
    if quiet:
        derive(board, derived, slots, fresh, numbers, elapsed_s)
        roll_on(
            position,
            board,
            now_s,
            wheels,
            own,
            robot,
            slots,
            fresh,
            heard_s,
            shares,
            angles,
            turned,
        )
        loss = clock[T_LOSS] * (1.0 - robot[R_LOSS_GAIN])
        quiet = asks_the_same(duties, fresh, loss)
        quiet = quiet and holds_as_before(position, conditions, code, fresh, origin, stack)
    if quiet and now_s >= surveyed[E_DUE_S]:
        kept_survey = surveyed.copy()
        kept_forces = forces.copy()
        quiet = survey(now_s, fresh, chain, parts, body, held, surveyed, forces, sorted_)
        if not quiet:
            surveyed[:] = kept_survey
            forces[:] = kept_forces
    if not quiet:
        memory[:] = kept
        shares[:] = kept_shares
        angles[:] = kept_angles
        return False
    numbers[:] = fresh
    heard_s[position] = now_s
    clock[T_LOSS] = loss
    return True
