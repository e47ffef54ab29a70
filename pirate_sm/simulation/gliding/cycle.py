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
    T_NOW_S,
    T_PASSED_S,
    U_BOARD,
    U_FIRST,
    U_LAST,
    U_REPORTS,
)
from pirate_sm.simulation.gliding.looking import look
from pirate_sm.simulation.gliding.quiet import take_frame
from pirate_sm.simulation.machine_code import compiled


@compiled
def may_begin(
    arcs: Floats,
    around: Floats,
    watch: Floats,
    clock: Floats,
    met: Ints,
    times_s: Floats,
    looker: Floats,
    points: Floats,
    crossings: Floats,
    seen: Floats,
    looks: Floats,
    values: Floats,
) -> bool:
    """Return whether another cycle may pass; if so, the clock stands at its end.

    A detector looks before, as often as it is due.
    """
    due_s = (clock[T_CYCLES] + 1.0) * around[G_CYCLE_S]
    while looker[L_DUE_S] < due_s and looker[L_DUE_S] < watch[A_UNTIL_S]:
        now_s = looker[L_DUE_S]
        if not look(arcs, looker, points, crossings, seen, looks, values):
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
    return bool(arcs.max() > around[G_BEFORE_M] and arcs.min() < around[G_BEHIND_M])


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
        numbers,
        heard_s,
        shares,
        angles,
        memory,
        fresh,
        turned,
        stack,
        chain,
        parts,
        body,
        held,
        surveyed,
        forces,
        sorted_,
    )
    if quiet:
        met[N_FRAMES] = at + 1
        return stays
    met[N_WAITING] = 1
    met[N_BOARD] = position
    return False
