"""One cycle of the bus after the physics has moved, in compiled code.

A physics has a function of its own that calls these two around its step, see
:mod:`pirate_sm.simulation.kinematic.kernel`.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints, Words
from pirate_sm.simulation.digitizing import digitize
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.looking import look, may_repeat, repeat, repeats
from pirate_sm.simulation.gliding.quiet import listen, looks_round, may_listen, take_frame
from pirate_sm.simulation.machine_code import compiled


@compiled
def _listens(
    now_s: float,
    rows: col.RobotRows,
    task: col.Task,
    clock: Floats,
    signals: Floats,
    posture: col.Posture,
    taken: col.Taken,
) -> bool:
    """Look for silent boards, and survey the pipe if that is due; return whether all is well."""
    boards, _, _, robot = rows
    _, _, origin, _, watch = task
    _, _, _, ticks, met = taken
    count = origin.shape[0]
    heard_s = signals[count : count + boards.shape[0]]
    if not may_listen(now_s, heard_s, robot, watch, ticks, met):
        return False
    if not looks_round(now_s, signals[:count], watch, posture):
        return False
    listen(now_s, 0.0, robot, watch, clock, ticks, met)
    return True


@compiled
def _repeats(
    arcs: Floats,
    task: col.Task,
    clock: Floats,
    signals: Floats,
    posture: col.Posture,
    sees: col.Looker,
    taken: col.Taken,
) -> bool:
    """Let the detector repeat its word; return whether that prolongs the word and no more."""
    _, _, origin, _, watch = task
    _, _, _, ticks, met = taken
    looker, _, _, _, _, _ = sees
    now_s, made = looker[col.L_DUE_S], looker[col.L_LOOKS]
    if not (may_repeat(looker, watch, clock, ticks, met) and look(arcs, sees)):
        return False
    if not looks_round(now_s, signals[: origin.shape[0]], watch, posture):
        looker[col.L_DUE_S], looker[col.L_LOOKS] = now_s, made  # the engine hears the word
        return False
    repeat(now_s, looker, watch, clock, ticks, met)
    return True


@compiled
def may_begin(
    arcs: Floats,
    around: Floats,
    rows: col.RobotRows,
    task: col.Task,
    clock: Floats,
    signals: Floats,
    posture: col.Posture,
    sees: col.Looker,
    taken: col.Taken,
) -> bool:
    """Return whether another cycle may pass; if so, the clock stands at its end.

    Before, silent boards are looked for, and a detector looks, as often as that is due.
    """
    _, _, _, _, watch = task
    looker, _, _, _, _, _ = sees
    times_s, _, _, _, met = taken
    due_s = (clock[col.T_CYCLES] + 1.0) * around[col.G_CYCLE_S]
    while min(looker[col.L_DUE_S], clock[col.T_LISTENING_S]) < min(
        due_s, watch[col.A_UNTIL_S], watch[col.A_ALARM_S]
    ):
        now_s = looker[col.L_DUE_S]
        if clock[col.T_LISTENING_S] <= now_s:  # the engine comes before the detector
            now_s = clock[col.T_LISTENING_S]
            if not _listens(now_s, rows, task, clock, signals, posture, taken):
                return False
        elif repeats(looker):
            if not _repeats(arcs, task, clock, signals, posture, sees, taken):
                return False
        elif not look(arcs, sees):
            return False
        clock[col.T_NOW_S] = max(clock[col.T_NOW_S], now_s)
    if (
        not due_s < min(watch[col.A_UNTIL_S], watch[col.A_ALARM_S])
        or met[col.N_FRAMES] == times_s.shape[0]
    ):
        return False
    clock[col.T_NOW_S] = max(clock[col.T_NOW_S], due_s)
    clock[col.T_CYCLES] += 1.0
    clock[col.T_PASSED_S] += around[col.G_CYCLE_S]
    return True


@compiled
def _touches(presses: Floats) -> bool:
    """Return whether a wheel presses a wall."""
    count = 0
    for press in presses:
        count += press != 0.0
    return count > 0


@compiled
def _stays(place: col.Place) -> bool:
    """Return whether the robot is in the pipe, with its parts in the plane of the bends."""
    quantities, rolls, arcs, around = place
    for part in range(1, rolls.shape[0]):
        if abs(rolls[part]) >= around[col.G_OUT_OF_PLANE]:
            return False
    if around[col.G_TOUCHING] != 0.0:
        first = col.PRESS * arcs.shape[0]
        return _touches(quantities[first : first + arcs.shape[0]])
    before, behind = True, True
    for arc_m in arcs:
        before = before and arc_m <= around[col.G_BEFORE_M]
        behind = behind and arc_m >= around[col.G_BEHIND_M]
    return not before and not behind


@compiled
def _measure(
    place: col.Place, turns: Ints, cycles: int, sources: Floats, counts: Floats, rng: Words
) -> bool:
    """Read the channels whose turn it is after a cycle; return whether the robot stays."""
    quantities, _, _, _ = place
    turn = turns[cycles % turns.shape[0]]
    digitize(sources, turn[col.U_FIRST], turn[col.U_LAST], quantities, counts, rng)
    return _stays(place)


@compiled
def may_pass(span: Floats, around: Floats) -> bool:
    """Return whether another cycle may pass with the duties in force; if so, it has begun."""
    if span[col.X_CYCLES] >= span[col.X_UNTIL]:
        return False
    span[col.X_CYCLES] += 1.0
    span[col.X_PASSED_S] += around[col.G_CYCLE_S]
    return True


@compiled
def passes_on(
    place: col.Place, turns: Ints, sources: Floats, counts: Floats, rng: Words, span: Floats
) -> bool:
    """Read the boards after a cycle; return whether the surroundings do nothing to the robot.

    Args:
        place: See `columns.py`; so for `span`.
        turns: Which channels each cycle reads.
        sources: The channel table, see `digitizing.digitize`.
        counts: The last count of every channel.
        rng: The state of the generator of noise.
        span: Changed.
    """
    stays = _measure(place, turns, int(span[col.X_CYCLES]), sources, counts, rng)
    span[col.X_MET] = 0.0 if stays else 1.0
    return stays


@compiled
def goes_on(
    place: col.Place,
    turns: Ints,
    electronics: col.Electronics,
    rows: col.RobotRows,
    task: col.Task,
    clock: Floats,
    signals: Floats,
    scratch: col.Scratch,
    posture: col.Posture,
    taken: col.Taken,
) -> bool:
    """Read the boards after a cycle; return whether its frame, if any, was quiet.

    Args:
        place: See `columns.py`; so for the other groups, `clock` and `signals`.
        turns: Which channels each cycle reads.
        electronics: The boards.
        rows: The robot.
        task: What is watched.
        clock: Changed.
        signals: Changed if the frame is quiet.
        scratch: As long as `signals`, and the stack of the machine.
        posture: For the survey of the pipe.
        taken: The frame is added.
    """
    sources, counts, rng, forced = electronics
    times_s, reporters, reports, ticks, met = taken
    boards, _, _, _ = rows
    turn = turns[int(clock[col.T_CYCLES]) % turns.shape[0]]
    stays = _measure(place, turns, int(clock[col.T_CYCLES]), sources, counts, rng)
    met[col.N_SURROUNDINGS] = 0 if stays else 1
    if turn[col.U_REPORTS] == 0:
        return stays
    position = turn[col.U_BOARD]
    at = met[col.N_FRAMES]
    values = reports[at]
    first = boards[position, col.B_ROW]
    for k in range(boards[position, col.B_VALUES]):
        shown = forced[first + k]
        values[k] = counts[first + k] if np.isnan(shown) else shown
    times_s[at] = clock[col.T_NOW_S]
    reporters[at] = position
    if take_frame(position, values, rows, task, clock, signals, scratch, posture, ticks, met):
        met[col.N_FRAMES] = at + 1
        return stays
    met[col.N_WAITING] = 1
    met[col.N_BOARD] = position
    return False


@compiled
def note_places(centres: Floats, rolls: Floats, cycles: float, trail: Floats) -> None:
    """Note where the robot is.

    Args:
        centres: Coordinates of the wheels' centres, one wheel after the other, m.
        rolls: Angle of the roll joint, then the roll of each part, rad.
        cycles: How many cycles have passed, in all.
        trail: A row for each of the last cycles: the centres, then the rolls. Changed.
    """
    row = trail[int(cycles) % trail.shape[0]]
    for k in range(centres.shape[0]):
        row[k] = centres[k]
    for k in range(rolls.shape[0]):
        row[centres.shape[0] + k] = rolls[k]
