"""One cycle of the bus after the physics has moved, in compiled code.

A physics has a function of its own that calls these two around its step, see
:mod:`pirate_sm.simulation.xpbd.glide`.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints, Words
from pirate_sm.simulation.digitizing import digitize
from pirate_sm.simulation.gliding.columns import (
    A_UNTIL_S,
    B_ROW,
    B_VALUES,
    G_BEFORE_M,
    G_BEHIND_M,
    G_CYCLE_S,
    G_OUT_OF_PLANE,
    L_DUE_S,
    N_BOARD,
    N_FRAMES,
    N_SURROUNDINGS,
    N_WAITING,
    T_CYCLES,
    T_LISTENING_S,
    T_NOW_S,
    T_PASSED_S,
    U_BOARD,
    U_FIRST,
    U_LAST,
    U_REPORTS,
)
from pirate_sm.simulation.gliding.listening import listen, may_listen
from pirate_sm.simulation.gliding.looking import look
from pirate_sm.simulation.gliding.quiet import looks_round, take_frame
from pirate_sm.simulation.machine_code import compiled


@compiled
def may_begin(
    arcs: Floats,
    around: Floats,
    boards: Ints,
    robot: Floats,
    origin: Floats,
    watch: Floats,
    clock: Floats,
    signals: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
    held: Ints,
    surveyed: Floats,
    times_s: Floats,
    ticks: Floats,
    met: Ints,
    looker: Floats,
    points: Floats,
    crossings: Floats,
    seen: Floats,
    looks: Floats,
    values: Floats,
) -> bool:
    """Return whether another cycle may pass; if so, the clock stands at its end.

    Before, silent boards are looked for, and a detector looks, as often as that is due.
    """
    due_s = (clock[T_CYCLES] + 1.0) * around[G_CYCLE_S]
    limit_s = min(due_s, watch[A_UNTIL_S])
    while min(looker[L_DUE_S], clock[T_LISTENING_S]) < limit_s:
        now_s = looker[L_DUE_S]
        if clock[T_LISTENING_S] <= now_s:  # the engine comes before the detector
            now_s = clock[T_LISTENING_S]
            numbers = signals[: origin.shape[0]]
            heard_s = signals[origin.shape[0] : origin.shape[0] + boards.shape[0]]
            if not (
                may_listen(now_s, heard_s, robot, watch, ticks, met)
                and looks_round(now_s, numbers, chain, parts, body, held, surveyed)
            ):
                return False
            listen(now_s, robot, watch, clock, ticks, met)
        elif not look(arcs, looker, points, crossings, seen, looks, values):
            return False
        clock[T_NOW_S] = max(clock[T_NOW_S], now_s)
    if not due_s < watch[A_UNTIL_S] or met[N_FRAMES] == times_s.shape[0]:
        return False
    clock[T_NOW_S] = max(clock[T_NOW_S], due_s)
    clock[T_CYCLES] += 1.0
    clock[T_PASSED_S] += around[G_CYCLE_S]
    return True


@compiled
def _stays(around: Floats, rolls: Floats, arcs: Floats) -> bool:
    """Return whether the robot is in the pipe, with its parts in the plane of the bends."""
    for part in range(1, rolls.shape[0]):
        if abs(rolls[part]) >= around[G_OUT_OF_PLANE]:
            return False
    before, behind = True, True
    for arc_m in arcs:
        before = before and arc_m <= around[G_BEFORE_M]
        behind = behind and arc_m >= around[G_BEHIND_M]
    return not before and not behind


@compiled
def goes_on(
    quantities: Floats,
    rolls: Floats,
    arcs: Floats,
    around: Floats,
    turns: Ints,
    sources: Floats,
    counts: Floats,
    rng: Words,
    forced: Floats,
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
    signals: Floats,
    fresh: Floats,
    stack: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
    held: Ints,
    surveyed: Floats,
    times_s: Floats,
    reporters: Ints,
    reports: Floats,
    met: Ints,
) -> bool:
    """Read the boards after a cycle; return whether its frame, if any, was quiet.

    - `quantities`: of the physics, in the layout of `physics.QuantityLayout`.
    - `rolls`: angle of the roll joint, then the roll of each part, rad.
    - `arcs`: position of each wheel along the pipe.
    - `sources`: the channel table of the electronics; see `digitizing.digitize`.
    - `counts`: the last count of every channel; changed.
    - `rng`: state of the generator of noise; changed.
    - `forced`: counts that defects show in place of those measured; NaN for the others.
    - `times_s`, `reporters`: time of each frame, and its board by its position; written.
    - `reports`: values of each frame, a row each; written. The row after the last may be a frame
      that waits for the engine.
    - `met`: what was met; written.

    The other arrays are described in :mod:`pirate_sm.simulation.gliding.columns`.
    """
    turn = turns[int(clock[T_CYCLES]) % turns.shape[0]]
    digitize(sources, turn[U_FIRST], turn[U_LAST], quantities, counts, rng)
    stays = _stays(around, rolls, arcs)
    met[N_SURROUNDINGS] = 0 if stays else 1
    if turn[U_REPORTS] == 0:
        return stays
    position = turn[U_BOARD]
    at = met[N_FRAMES]
    values = reports[at]
    first = boards[position, B_ROW]
    for k in range(boards[position, B_VALUES]):
        shown = forced[first + k]
        values[k] = counts[first + k] if np.isnan(shown) else shown
    times_s[at] = clock[T_NOW_S]
    reporters[at] = position
    quiet = take_frame(
        position,
        clock[T_NOW_S],
        values,
        boards,
        channels,
        derived,
        wheels,
        own,
        sensors,
        robot,
        slots,
        conditions,
        code,
        origin,
        duties,
        watch,
        clock,
        signals,
        fresh,
        stack,
        chain,
        parts,
        body,
        held,
        surveyed,
    )
    if quiet:
        met[N_FRAMES] = at + 1
        return stays
    met[N_WAITING] = 1
    met[N_BOARD] = position
    return False
