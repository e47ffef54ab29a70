"""Survey the pipe around the robot in compiled code, as long as there is nothing to report.

What is remembered is the same to the bit as in :mod:`pirate_sm.core.sensing`. What
would be reported is only compared with the last report. Where rounding could decide, the engine
surveys.
"""

from __future__ import annotations

from math import asin, atan2, cos, pi, sin, sqrt

import numpy as np

from pirate_sm.core.geometry import GRAVITY_M_S2
from pirate_sm.core.sensing import (
    AGREEING,
    AT_REST,
    COPLANAR_RAD,
    LEAST_SAMPLES,
    NOISE_M,
    NOISE_RAD,
    OPEN_RAD,
    SAMPLES,
    STEP,
    SURVEY_EVERY_S,
    TURNED_RAD,
    UPRIGHT,
)
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding import columns as col
from pirate_sm.simulation.gliding.columns import Looker
from pirate_sm.simulation.machine_code import compiled

# --- posture -------------------------------------------------------------------------------------
# The same operations in the same order give the same bits as
# :meth:`pirate_sm.core.sensing.BodySpec.heading_in_pipe`.


@compiled
def _angle(wheel: int, numbers: Floats, chain: Floats) -> float:
    joint = int(chain[wheel, col.H_JOINT])
    return float(numbers[joint]) if joint >= 0 else 0.0


@compiled
def _heading(link: int, first: int, numbers: Floats, chain: Floats) -> float:
    """Return the heading of a link relative to the one behind wheel ``first``."""
    heading = 0.0
    for passed in range(first + 1, link + 1):
        heading = heading + _angle(passed, numbers, chain)
    for passed in range(first - 1, link - 1, -1):
        heading = heading - _angle(passed + 1, numbers, chain)
    return heading


@compiled
def _lean(first: int, last: int, aside_m: float, numbers: Floats, chain: Floats) -> float:
    """Return the rotation of the chain that aligns a part with the pipe, rad."""
    x, y = 0.0, 0.0
    for link in range(first, last):  # the first wheel stands at the origin
        heading = _heading(link, first, numbers, chain)
        x -= chain[link, col.H_LENGTH] * cos(heading)
        y -= chain[link, col.H_LENGTH] * sin(heading)
    along, across = 0.0 - x, 0.0 - y
    length = sqrt(along * along + across * across)
    if length == 0.0:
        length = 1.0
    rise = (chain[first, col.H_SIDE] - chain[last, col.H_SIDE]) * aside_m / length
    if np.isnan(rise):
        return np.nan
    return asin(max(-1.0, min(1.0, rise))) - atan2(across, along)


@compiled
def heading_in_pipe(
    part: int, link: int, numbers: Floats, chain: Floats, parts: Floats, body: Floats
) -> float:
    """Return a link's heading relative to the pipe axis at a clamped part, rad; NaN is unknown."""
    first, last = int(parts[part, col.Q_FIRST]), int(parts[part, col.Q_LAST])
    aside_m = 0.0
    if chain[first, col.H_SIDE] != chain[last, col.H_SIDE]:
        diameter = int(parts[part, col.Q_DIAMETER])
        span_m = numbers[diameter] if diameter >= 0 else np.nan
        aside_m = span_m / 2 - body[col.I_RADIUS_M]
    turn = _lean(first, last, aside_m, numbers, chain)
    return _heading(link, min(first, chain.shape[0] - 2), numbers, chain) + turn


# --- medians -------------------------------------------------------------------------------------


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
def median(rows: Floats, column: int, count: int, sorted_: Floats) -> float:
    """Return the median of a column of the first rows; `sorted_` is scratch."""
    for k in range(count):
        sorted_[k] = rows[k, column]
    return median_of(sorted_, count)


# --- the survey ----------------------------------------------------------------------------------


UNKNOWN, OUT, STRAIGHT, JOINT = range(4)
"""The segments as numbers."""

_DOUBT = 1e-9
"""Values that differ from a limit by less are left to the engine."""


@compiled
def _walled(held: Ints, parts: Floats, numbers: Floats, walled: Ints) -> int:
    """Write the held parts that touch a wall; return how many there are."""
    count = 0
    for part in held:
        angle = int(parts[part, col.Q_ANGLE])
        if angle >= 0 and abs(numbers[angle]) > parts[part, col.Q_STOP] - OPEN_RAD:
            continue
        walled[count] = part
        count += 1
    return count


@compiled
def _turn(
    walled: Ints, count: int, numbers: Floats, chain: Floats, parts: Floats, body: Floats
) -> float:
    """Return the largest angle between the axes of the parts, rad; 0 if it is unknown."""
    roll = int(body[col.I_ROLL])
    if roll >= 0 and not abs(numbers[roll]) <= COPLANAR_RAD:
        return 0.0
    least, most = np.inf, -np.inf
    for k in range(count):
        heading = heading_in_pipe(walled[k], 0, numbers, chain, parts, body)
        if not np.isnan(heading):
            least, most = min(least, heading), max(most, heading)
    return most - least if most > -np.inf else 0.0


@compiled
def _segment(
    held: Ints,
    walled: Ints,
    count: int,
    surveyed: Floats,
    numbers: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
) -> int:
    """Return the segment around the robot; -1 where rounding could decide."""
    in_bend = surveyed[col.E_IN_BEND] != 0.0
    if surveyed[col.E_WORD] != 0.0 and in_bend:
        return JOINT
    if held.shape[0] > 0 and count == 0:
        return OUT
    if count == 0:
        return UNKNOWN
    if count > 1:
        turn = _turn(walled, count, numbers, chain, parts, body)
        if abs(turn - TURNED_RAD) < _DOUBT:
            return -1
        if turn > TURNED_RAD:
            return JOINT
    return UNKNOWN if in_bend else STRAIGHT


@compiled
def _copy(some: Ints, count: int, to: Ints) -> None:
    for k in range(count):
        to[k] = some[k]


@compiled
def _along(
    walled: Ints, count: int, straight_m: float, parts: Floats, numbers: Floats, along: Ints
) -> int:
    """Write the parts that show the last straight's diameter; return how many there are."""
    if np.isnan(straight_m):
        if count < 2:
            return 0
        _copy(walled, count, along)
        return count
    found = 0
    for k in range(count):
        diameter = int(parts[walled[k], col.Q_DIAMETER])
        if diameter >= 0 and abs(numbers[diameter] - straight_m) <= AGREEING * straight_m:
            along[found] = walled[k]
            found += 1
    return found


@compiled
def _diameter(walled: Ints, count: int, parts: Floats, numbers: Floats) -> float:
    """Return the mean inner diameter that the parts show, m; NaN if unknown or different."""
    known, sum_m, least, most = 0, 0.0, np.inf, -np.inf
    for k in range(count):
        diameter = int(parts[walled[k], col.Q_DIAMETER])
        if diameter < 0 or np.isnan(numbers[diameter]):
            continue
        known += 1
        sum_m += numbers[diameter]
        least, most = min(least, numbers[diameter]), max(most, numbers[diameter])
    if known == 0 or most - least > AGREEING * most:
        return np.nan
    return sum_m / known


@compiled
def _feel(
    part: int,
    now_s: float,
    surveyed: Floats,
    forces: Floats,
    numbers: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
) -> bool:
    """Remember the force in the axes of the pipe; return whether rounding could not decide."""
    if part != int(surveyed[col.E_PART]):
        surveyed[col.E_FORCES] = 0.0
    count = int(surveyed[col.E_FORCES])
    ahead, side, up = np.nan, np.nan, np.nan
    if part >= 0 and body[col.I_LINK] >= 0.0:
        x, y = numbers[int(body[col.I_AHEAD])], numbers[int(body[col.I_SIDE])]
        up = numbers[int(body[col.I_UP])]
        if body[col.I_ROLL] >= 0.0 and parts[part, col.Q_FIRST] > body[col.I_LINK]:
            turn = -numbers[int(body[col.I_ROLL])]
            y, up = y * cos(turn) - up * sin(turn), y * sin(turn) + up * cos(turn)
        turn = -heading_in_pipe(part, int(body[col.I_LINK]), numbers, chain, parts, body)
        ahead, side = x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)
    away = abs(sqrt(ahead * ahead + side * side + up * up) - GRAVITY_M_S2)
    if abs(away - AT_REST * GRAVITY_M_S2) < _DOUBT:
        return False
    if away <= AT_REST * GRAVITY_M_S2:
        if count == SAMPLES:
            for k in range(1, SAMPLES):
                for axis in range(3):
                    forces[k - 1, axis] = forces[k, axis]
            count -= 1
        forces[count, 0], forces[count, 1], forces[count, 2] = ahead, side, up
        surveyed[col.E_FORCES] = count + 1
        surveyed[col.E_FELT_S] = now_s
    elif not now_s - surveyed[col.E_FELT_S] < body[col.I_LASTING_S]:
        surveyed[col.E_FORCES] = 0.0
    return True


@compiled
def _near(old: float, new: float, noise: float, turn: float) -> bool:
    """Return whether a value is surely what was reported, but for noise and whole turns."""
    if np.isnan(old) or np.isnan(new):
        return bool(np.isnan(old) and np.isnan(new))
    away = new - old
    if turn > 0.0:
        away -= turn * np.rint(away / turn)
    return bool(abs(away) < noise - _DOUBT)


@compiled
def _looks_level(surveyed: Floats, forces: Floats, sorted_: Floats) -> bool:
    """Return whether roll and pitch are surely what was reported; `sorted_` is memory."""
    count = int(surveyed[col.E_FORCES])
    roll, pitch = np.nan, np.nan
    if count >= LEAST_SAMPLES:
        along = median(forces, 0, count, sorted_)
        side = median(forces, 1, count, sorted_)
        up = median(forces, 2, count, sorted_)
        across = sqrt(side * side + up * up)
        if abs(across - UPRIGHT * GRAVITY_M_S2) < _DOUBT:
            return False
        if across > UPRIGHT * GRAVITY_M_S2:
            roll = atan2(-side, up)
        pitch = atan2(along, across)
    return _near(surveyed[col.E_ROLL], roll, NOISE_RAD, 2.0 * pi) and _near(
        surveyed[col.E_PITCH], pitch, NOISE_RAD, 0.0
    )


@compiled
def _steps(walled: Ints, parts: Floats, numbers: Floats) -> bool:
    """Return whether two parts may show a reducer; which axes they have is not asked."""
    one = int(parts[walled[0], col.Q_DIAMETER])
    other = int(parts[walled[1], col.Q_DIAMETER])
    if one < 0 or other < 0:
        return False
    most = max(numbers[one], numbers[other])
    return bool(abs(numbers[one] - numbers[other]) > (1.0 - _DOUBT) * STEP * most)


@compiled
def survey(
    now_s: float,
    numbers: Floats,
    chain: Floats,
    parts: Floats,
    body: Floats,
    held: Ints,
    surveyed: Floats,
) -> bool:
    """Survey the pipe; return whether there is surely nothing to report.

    If there may be, `surveyed` has been changed and is of no use. The first row of `held` has the
    parts that count, the others are memory; the other arrays are described in
    :mod:`pirate_sm.simulation.gliding.columns`.
    """
    end = col.SURVEY_ENTRIES + 3 * SAMPLES
    forces = surveyed[col.SURVEY_ENTRIES : end].reshape(SAMPLES, 3)
    walled, along = held[1], held[2]
    count = _walled(held[0], parts, numbers, walled)
    if count > 2:  # the sum of more numbers depends on how it is made
        return False
    segment = _segment(held[0], walled, count, surveyed, numbers, chain, parts, body)
    if segment == STRAIGHT and count == 2 and _steps(walled, parts, numbers):
        return False
    lying = _along(walled, count, surveyed[col.E_STRAIGHT_M], parts, numbers, along)
    if segment == STRAIGHT:
        if lying == 0:
            lying = count
            _copy(walled, count, along)
    else:
        count = lying
        _copy(along, count, walled)
    part = along[0] if lying > 0 else -1
    for k in range(lying):
        if along[k] == int(surveyed[col.E_PART]):
            part = along[k]
    if not _feel(part, now_s, surveyed, forces, numbers, chain, parts, body):
        return False
    diameter_m = _diameter(walled, count, parts, numbers)
    if segment == STRAIGHT and not np.isnan(diameter_m):
        surveyed[col.E_STRAIGHT_M] = diameter_m
    surveyed[col.E_PART] = part
    surveyed[col.E_DUE_S] = now_s + SURVEY_EVERY_S
    surveyed[col.E_MADE] += 1.0
    same = segment == int(surveyed[col.E_SEGMENT])
    same = same and _near(surveyed[col.E_DIAMETER_M], diameter_m, NOISE_M, 0.0)
    return same and _looks_level(surveyed, forces, surveyed[end:])


# --- looks of a detector -------------------------------------------------------------------------
# The same operations in the same order give the same bits as
# :class:`pirate_sm.robot.detectors.word_timing.WordDetector` and
# :class:`pirate_sm.robot.detectors.word_timing.Tracker`.


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
