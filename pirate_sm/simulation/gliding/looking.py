"""Look for a detector in compiled code, as long as it has nothing new to say.

The same operations in the same order give the same bits as
:class:`pirate_sm.robot.detectors.word_timing.WordDetector` and
:class:`pirate_sm.robot.detectors.word_timing.Tracker`.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.columns import Looker
from pirate_sm.simulation.machine_code import compiled


@compiled
def median_of(values: Floats, count: int) -> float:
    """Return the median of the first values, which are sorted; 0 for none."""
    for i in range(1, count):
        value = values[i]
        k = i
        while k > 0 and values[k - 1] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value
    if count == 0:
        return 0.0
    middle = count // 2
    if count % 2 == 1:
        return float(values[middle])
    return float((values[middle - 1] + values[middle]) / 2)


@compiled
def _place(column: int, count: int, driven: bool, seen: Floats, values: Floats) -> float:
    """Return the filtered position of a wheel at the time of the last look."""
    slope = 0.0
    if driven and count >= 2:
        half = count // 2
        pairs = 0
        for i in range(count - half):
            passed_s = seen[i + half, 0] - seen[i, 0]
            if seen[i + half, 0] > seen[i, 0]:
                values[pairs] = (seen[i + half, column] - seen[i, column]) / passed_s
                pairs += 1
        slope = median_of(values, pairs)
    latest_s = seen[count - 1, 0]
    for i in range(count):
        values[i] = seen[i, column] + slope * (latest_s - seen[i, 0])
    return median_of(values, count)


@compiled
def _word(
    count: int, looker: Floats, points: Floats, bends: Floats, seen: Floats, values: Floats
) -> int:
    """Return the index of the word that holds; -1 for none, -2 if a position is unknown."""
    direction = looker[col.L_DIRECTION]
    if direction == 0.0:
        return -1
    driven = looker[col.L_DRIVEN] != 0.0
    for k in range(bends.shape[0]):
        for p in range(points.shape[0]):
            place_m = _place(int(points[p, col.O_WHEEL]) + 1, count, driven, seen, values)
            passed_m = direction * (place_m - bends[k, 0])
            passed_m += points[p, col.O_MORE_M]
            passed_m += bends[k, 1] if p == points.shape[0] - 1 else -bends[k, 1]
            if np.isnan(passed_m):
                return -2
            if passed_m >= (-looker[col.L_SLACK_M] if p == looker[col.L_WORD] else 0.0):
                if passed_m < looker[col.L_FORGOTTEN_M]:
                    return p
                break
    return -1


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
    looker, points, bends, seen, looks, values = sees
    now_s = looker[col.L_DUE_S]
    count = int(looker[col.L_SEEN])
    made = int(looker[col.L_LOOKS])
    if made == looks.shape[0]:
        return False
    first = 0
    while first < count and seen[first, 0] < now_s - looker[col.L_WINDOW_S]:
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
    if _word(count + 1, looker, points, bends, seen, values) != int(looker[col.L_WORD]):
        return False
    looker[col.L_SEEN] = count + 1
    looker[col.L_LOOKS] = made + 1
    looker[col.L_DUE_S] = now_s + looker[col.L_EVERY_S]
    return True
