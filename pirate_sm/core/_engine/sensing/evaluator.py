"""Run rows of a table of signals.

This is plain Python for the engine, and the simulator compiles the same source
(:func:`pirate_sm.simulation.machine_code.compiled_module`). So it is made of floats, integers and
sequences of them, and a function comes after those that it calls. NaN is unknown.

A row is an operation and four integers `t, a, b, c`, which are indexes of cells unless said
otherwise; `t` is the cell that is written.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, inf, isfinite, isnan, nan, sin, sqrt

SCALE = 0
"""The raw value at place `a`, times `b`, less `c`."""

RATE = 1
"""The change of `a` by the frame, per second."""

TORQUE = 2
"""The current `a` times `c`, with the sign of the setpoint `b` (eq. 5-3)."""

RANGE, STEP = 3, 4
"""Limits. `t` must be from `b` to `c`; or differ by at most `b` per second and `c` from before."""

NORM, ROLL, PITCH = 5, 6, 7
"""Length and angles of the vector `a, b, c` (B-13, B-14)."""

DIAMETER = 8
"""What a V spans whose apex has the angle `a`: a leg is `b` long, the wheels add `c` (eq. 3-2)."""

ODOMETRY = 9
"""Add what a wheel has rolled. It is at place `a` of the lists, all wheels are at place `b`, see
:data:`WHEEL`; `t` is -1 where the distance is not counted."""

SPEED = 10
"""The mean speed of the driven wheels, or of all wheels if none is; they are at place `a`."""

LOSS = 11
"""The share of lost reports, a running mean; `a` is the period of the reports."""

HEARD = 12
"""The time of the frame."""

STUCK, REST = 13, 14
"""Limits of what a motion sensor `t` shows: its motion while its motor is driven without load, its
rest while nothing is asked of it. Its memory is from cell `a` on, see :data:`UNMOVED`, what it is
judged by is at place `b` of the lists, see :data:`MOTION`. `c` is its place among the sensors of
its board. These limits do not end a run."""

GAIN = 1 / 64
"""Weight of one report in the share that is lost; six boards with a period of 0.1 s send 64 in
about a second."""

MOST_MISSED = 8.0
"""Largest gap in reports; a longer one is a silent board, not a lossy line."""

WHEEL = 9
"""So many entries of the lists describe a wheel: the number of its angle and of its speed; cells
with the angle last shown, its share, when its board reported, whether it is not believed, its
metres per rad, its setpoint in force and that last sent, either of which drives it. Before the
first come their number and the cell with the time after which a board counts as silent."""


UNMOVED = (nan, inf, nan, inf, 0.0, 0.0, 0.0)
"""The memory of a motion sensor at first: the constant reading and since when it is shown while
the motor is driven without load (:data:`STUCK`); the reading at rest, when what it rests by was
asked, whether a second reading has confirmed it, how many readings after one another were far from
it, and whether that was found (:data:`REST`)."""

JUST_MOVED = 2.0
"""The last of these, in the frame that shows it."""

MOTION = 11
"""So many entries of the lists say what a motion sensor is judged by: cells of its motor's setpoint
and current; its least duty, share of the load, full load, time; how far it may move, how many
readings count, how long all takes to settle; cells of the time of the last request and whether that
drives wheels."""


def loss_after(loss: float, elapsed_s: float, period_s: float) -> float:
    """Return the share of lost reports after one more report.

    Args:
        loss: The share before, a running mean over the reports of all boards.
        elapsed_s: Time since the same board's last report.
        period_s: Time between two reports of one board without loss.
    """
    if elapsed_s > 1.5 * period_s:
        missed = float(round(min(elapsed_s / period_s - 1, MOST_MISSED)))
        loss = 1 - (1 - loss) * (1 - GAIN) ** missed
    return loss * (1 - GAIN)


def vector(operation: int, x: float, y: float, z: float) -> float:
    """Return the length of a vector, or how it rolls or pitches; see :data:`NORM`."""
    if operation == NORM:
        return sqrt(x * x + y * y + z * z)
    if isnan(x) or isnan(y) or isnan(z):
        return nan
    # atan2 gives the same as B-13 and B-14 for an upright sensor, and is valid in all quadrants.
    return atan2(-y, z) if operation == ROLL else atan2(x, sqrt(y * y + z * z))


def diameter_m(apex_rad: float, leg_m: float, wheels_m: float) -> float:
    """Return what a V spans whose apex has this angle (eq. 3-2); NaN is unknown."""
    angle = apex_rad if isfinite(apex_rad) else nan
    return abs(leg_m * sin(angle / 2)) + wheels_m


def is_driven(wheel: int, lists: Sequence[int], cells: Sequence[float]) -> bool:
    """Return whether a wheel of the lists is driven."""
    return cells[lists[wheel + 7]] != 0.0 or cells[lists[wheel + 8]] != 0.0


def sharing(
    wheels: int, heard: int, limit_s: float, lists: Sequence[int], cells: Sequence[float]
) -> int:
    """Return how many driven, measured wheels share in the odometry.

    Args:
        wheels: Where the wheels are in the lists.
        heard: The cell of the board that reports.
        limit_s: Another board must have reported after this time.
        lists: See :data:`WHEEL`.
        cells: All cells.
    """
    count, begin = 0, wheels + 2
    for at in range(begin, begin + lists[wheels] * WHEEL, WHEEL):
        if is_driven(at, lists, cells) and cells[lists[at + 5]] == 0.0:
            own = lists[at + 4] == heard
            known = not isnan(cells[lists[at]] if own else cells[lists[at + 2]])
            if known and (own or cells[lists[at + 4]] > limit_s):
                count += 1
    return count


def roll_on(
    odometry: int, at: int, wheels: int, lists: Sequence[int], cells: list[float], now_s: float
) -> None:
    """Count what a wheel has rolled; the arguments are those of :data:`ODOMETRY`.

    Odometry is the mean distance rolled by the driven, measured wheels. A wheel's share is added
    when its board reports, for the whole time since its last report. A wheel whose board has been
    silent long enough for a fault gets no share from then on; the other wheels replace it. Nor does
    one that is not believed, see :mod:`pirate_sm.core._engine.sensing.wheels`.
    """
    number, angle, own, heard = lists[at], lists[at + 2], lists[at + 3], lists[at + 4]
    silent_s = cells[lists[wheels + 1]]
    silence_s = now_s - cells[heard]
    part = min(1.0, silent_s / silence_s) if silence_s > 0.0 else 1.0
    doubted, share = cells[lists[at + 5]] != 0.0, 0.0
    if not doubted and is_driven(at, lists, cells):
        count = sharing(wheels, heard, now_s - silent_s, lists, cells)
        share = 1.0 / count if count > 0 else 0.0
    old = cells[own] if cells[own] != 0.0 and not doubted else share
    turned = cells[number] - cells[angle]
    cells[own] = share
    cells[angle] = cells[number]
    if odometry >= 0 and not isnan(turned):
        cells[odometry] += turned * cells[lists[at + 6]] * old * part


def mean_speed(wheels: int, lists: Sequence[int], cells: Sequence[float]) -> float:
    """Return the mean speed of the measured driven wheels, or of all wheels if none is driven."""
    known, total, every, whole = 0, 0.0, 0, 0.0
    begin = wheels + 2
    for at in range(begin, begin + lists[wheels] * WHEEL, WHEEL):
        speed = cells[lists[at + 1]] * cells[lists[at + 6]]
        if not isnan(speed):
            every, whole = every + 1, whole + speed
            if cells[lists[at + 7]] != 0.0 or cells[lists[at + 8]] != 0.0:  # no call: each frame
                known, total = known + 1, total + speed
    if known > 0:
        return total / known
    return whole / every if every > 0 else nan


def turns(
    number: int, memory: int, at: int, lists: Sequence[int], cells: list[float], now_s: float
) -> bool:
    """Remember how long a driven motor shows no motion; return whether that is not too long."""
    duty = abs(cells[lists[at]])
    driven = duty > cells[lists[at + 2]] and cells[lists[at + 9]] < inf
    if not driven and cells[memory + 1] == inf:
        return True
    load = abs(cells[lists[at + 1]])
    if not (driven and load < cells[lists[at + 3]] * duty * cells[lists[at + 4]]):
        cells[memory + 1] = inf
    elif cells[memory + 1] == inf or cells[number] != cells[memory]:
        cells[memory] = cells[number]
        cells[memory + 1] = now_s
    return not now_s - cells[memory + 1] >= cells[lists[at + 5]]


def rests(
    number: int, memory: int, at: int, lists: Sequence[int], cells: list[float], now_s: float
) -> bool:
    """Remember where a sensor rests; return whether it has not just left that place for long."""
    value, since_s = cells[number], cells[lists[at + 9]]
    settled = cells[lists[at + 10]] == 0.0 and now_s - since_s >= cells[lists[at + 8]]
    if not settled or cells[lists[at]] != 0.0 or isnan(value):
        return True
    readings, away = cells[lists[at + 7]], cells[memory + 5]
    if cells[memory + 3] != since_s:
        cells[memory + 2], cells[memory + 3] = value, since_s
        cells[memory + 4], cells[memory + 5], cells[memory + 6] = 0.0, 0.0, 0.0
    elif abs(value - cells[memory + 2]) <= cells[lists[at + 6]]:
        cells[memory + 4], cells[memory + 5] = 1.0, 0.0
    elif cells[memory + 4] == 0.0 and away < readings:
        # Each of the two readings may be corrupt.
        cells[memory + 2], cells[memory + 5] = value, away + 1.0
    elif away + 1.0 < readings:
        cells[memory + 5] = away + 1.0
    elif cells[memory + 6] == 0.0:
        cells[memory + 6] = JUST_MOVED
        return False
    return True


def run(  # noqa: C901 - one branch for each operation
    rows: Sequence[Sequence[int]],
    lists: Sequence[int],
    cells: list[float],
    before: Sequence[float],
    raw: Sequence[float],
    now_s: float,
    elapsed_s: float,
) -> bool:
    """Run rows for a frame.

    Args:
        rows: The rows.
        lists: Operands of which there are many.
        cells: All cells; changed.
        before: The signals before the frame.
        raw: The values of the frame.
        now_s: When it came.
        elapsed_s: Time since the board's last frame, at least its period.

    Returns:
        Whether every limit is kept; the first value that is not plausible ends the run.
    """
    kept = True
    for row in rows:
        operation, t, a = row[0], row[1], row[2]
        if operation == SCALE:
            cells[t] = raw[a] * cells[row[3]] - cells[row[4]]
        elif operation == RATE:
            cells[t] = (cells[a] - before[a]) / elapsed_s
        elif operation == RANGE:
            if not cells[row[3]] <= cells[t] <= cells[row[4]]:
                return False
        elif operation == STEP:
            if not abs(cells[t] - before[t]) <= cells[row[3]] * elapsed_s + cells[row[4]]:
                return False
        elif operation == STUCK:
            kept = turns(t, a, row[3], lists, cells, now_s) and kept
        elif operation == REST:
            kept = rests(t, a, row[3], lists, cells, now_s) and kept
        elif operation == TORQUE:
            setpoint = cells[row[3]]
            sign = setpoint / abs(setpoint) if setpoint != 0.0 else 0.0  # NaN stays NaN
            cells[t] = cells[a] * cells[row[4]] * sign
        elif operation == HEARD:
            cells[t] = now_s
        elif operation == LOSS:
            cells[t] = loss_after(cells[t], elapsed_s, cells[a])
        elif operation == ODOMETRY:
            roll_on(t, a, row[3], lists, cells, now_s)
        elif operation == SPEED:
            cells[t] = mean_speed(a, lists, cells)
        elif operation == DIAMETER:
            cells[t] = diameter_m(cells[a], cells[row[3]], cells[row[4]])
        else:
            cells[t] = vector(operation, cells[a], cells[row[3]], cells[row[4]])
    return kept
