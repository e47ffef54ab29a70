"""Look for a detector in compiled code, as long as it has nothing new to say."""

from __future__ import annotations

import numpy as np

from pirate_sm.robot.detectors import place_filter
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.columns import Looker
from pirate_sm.simulation.machine_code import compiled, compiled_module

_filter = compiled_module(place_filter)
_place_of, _word_at = _filter["place_of"], _filter["word_at"]


@compiled
def _word(
    count: int, looker: Floats, points: Floats, bends: Floats, seen: Floats, work: Floats
) -> int:
    """Return the number of the word that holds; -1 for none."""
    direction, driven, places_m = looker[col.L_DIRECTION], looker[col.L_DRIVEN] != 0.0, work[3]
    for k in range(points.shape[0]):
        places_m[k] = _place_of(int(points[k, col.O_WHEEL]), driven, count, seen, work)
    return int(_word_at(int(looker[col.L_WORD]), direction, places_m, points, bends))


@compiled
def repeats(looker: Floats) -> bool:
    """Return whether the present word is due again at the next look."""
    return bool(looker[col.L_DUE_S] - looker[col.L_SAID_S] >= looker[col.L_REPEAT_S])


@compiled
def may_repeat(looker: Floats, watch: Floats, clock: Floats, ticks: Floats, met: Ints) -> bool:
    """Return whether the engine would do nothing but prolong the word. See `columns.py`."""
    now_s, due_s = looker[col.L_DUE_S], min(watch[col.A_ALARM_S], clock[col.T_LISTENING_S])
    until_s = min(watch[col.A_DEADLINE_S], now_s + looker[col.L_VALID_S])
    if looker[col.L_VALID_S] == 0.0 or met[col.N_TICKS] == ticks.shape[0]:
        return False
    return bool(now_s < due_s - col.TOLERANCE_S and min(until_s, clock[col.T_LISTENING_S]) == due_s)


@compiled
def repeat(
    now_s: float, looker: Floats, watch: Floats, clock: Floats, ticks: Floats, met: Ints
) -> None:
    """Say the present word again. See `columns.py` for the arrays."""
    looker[col.L_SAID_S] = now_s
    clock[col.T_WORD_S] = now_s + looker[col.L_VALID_S]
    watch[col.A_ALARM_S] = min(watch[col.A_DEADLINE_S], clock[col.T_WORD_S])
    ticks[met[col.N_TICKS], col.J_AT_S] = now_s
    ticks[met[col.N_TICKS], col.J_WAKE_S] = np.inf
    ticks[met[col.N_TICKS], col.J_OF_FRAME] = 0.0
    met[col.N_TICKS] += 1


@compiled
def look(arcs: Floats, sees: Looker) -> bool:
    """Look at the time at which it is due; return whether there is nothing new to say.

    If there is, the look has not been made. `arcs` has the position of each wheel along the pipe.
    """
    looker, points, bends, seen, looks, work = sees
    now_s = looker[col.L_DUE_S]
    count = int(looker[col.L_SEEN])
    made = int(looker[col.L_LOOKS])
    if made == looks.shape[0]:
        return False
    first = 0
    while first < count and seen[first, 0] < now_s - place_filter.WINDOW_S:
        first += 1
    if first == 0 and count == seen.shape[0]:
        return False
    looks[made, 0] = now_s
    for wheel in range(arcs.shape[0]):
        looks[made, wheel + 1] = arcs[wheel]
    for column in range(seen.shape[1]):
        for i in range(first, count):
            seen[i - first, column] = seen[i, column]
        seen[count - first, column] = looks[made, column]
    count -= first
    if _word(count + 1, looker, points, bends, seen, work) != int(looker[col.L_WORD]):
        return False
    looker[col.L_SEEN] = count + 1
    looker[col.L_LOOKS] = made + 1
    looker[col.L_DUE_S] = now_s + looker[col.L_EVERY_S]
    return True
