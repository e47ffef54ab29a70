"""Survey the pipe around the robot by plain numbers; :mod:`environment` says what is derived.

This is plain Python for the engine, and the simulator compiles the same source, as it does with
:mod:`evaluator`: floats, integers and sequences of them, and a function comes after those that it
calls. NaN is unknown. A signal is given by its index, which is -1 where there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import asin, atan2, cos, hypot, inf, isnan, nan, pi, radians, sin, sqrt
from typing import TypeAlias

from pirate_sm.core._geometry.space import GRAVITY_M_S2

NOISE_RAD, NOISE_M = radians(1), 1e-3
"""Smaller changes are not reported."""

STEP = 0.03
"""Smallest relative difference of two diameters that is a reducer, more than noise [decided]."""

SURVEY_EVERY_S = 0.2
"""Frequent enough at 0.1 m/s, and rare compared with the cost of one evaluation [decided]."""

SAMPLES = 9
"""Length of the median filter of accelerations; it removes the jolts of motors [decided]."""

AGREEING = 0.03
"""Largest relative difference of the diameters of parts in one straight [decided]."""

_ALONG_RAD = radians(2)
"""Parts whose axes differ by less lie along one axis [decided]."""

_AT_REST = 0.1
"""Largest relative deviation from gravity of an acceleration that counts as its direction."""

_UPRIGHT = 0.2
"""With a smaller share of gravity across the pipe (78 deg), the roll is undefined."""

_TURNED_RAD = radians(20)
"""Two clamped parts whose axes differ by more are in different legs of the pipe [decided]."""

_COPLANAR_RAD = radians(10)
"""Headings of parts are compared only up to this roll between them."""

_LEAST_SAMPLES = 5
"""Roll and pitch are unknown with fewer accelerations."""

_OPEN_RAD = radians(2)
"""A clamped V nearer to its end stop touches no wall [decided]."""

# --- what is surveyed -------------------------------------------------------------------------

Rows: TypeAlias = Sequence[Sequence[float]]

ANGLE, SIDE, LENGTH = range(3)
"""A row of the chain, per wheel: the signal of its joint's angle, the side that it touches, the
length of the link behind it."""

APEX, DIAMETER, END_STOP, FRONT, REAR, RADIUS = range(6)
"""A row per part, see `body_spec.Vee`: the signals of the angle at its apex and of its diameter,
its end stop, its first and its last wheel, the radius of a wheel."""

LINK, AHEAD, SIDE_B, UP, TWIST = range(5)
"""The accelerometer, see `body_spec.Imu`: its link, the signals of its axes and of its roll."""

UNKNOWN, OUT, STRAIGHT, JOINT = range(4)
"""The segments as numbers."""

# --- the memory -------------------------------------------------------------------------------

PART, FELT_S, STRAIGHT_M, DUE_S, COUNT = range(5)
"""It begins with what one survey leaves to the next, see `environment.Surveyed`, and how many
forces are remembered."""

IN_BEND, WORD, LASTING_S = range(5, 8)
"""Whether a word has announced a bend, whether a word is valid, how long forces last."""

SEGMENT, ROLL, PITCH, DIAMETER_M, AHEAD_M, SAID = range(8, 14)
"""What is found: the segment, the attitude, the diameter, and that ahead of a step. After these
the first four as they were reported last."""

FORCES = SAID + 4
"""The forces, each with its three components; then room to sort one of these."""

_SORTED = FORCES + 3 * SAMPLES

MARKS = _SORTED + SAMPLES

PER_PART, _SHOWN_M, _HEADING = 3, 1, 2
"""Last come so many entries for each part: a mark, the diameter that it shows, the heading of the
first link in its pipe."""

HELD, _WALLED, _ALONG = 1.0, 2.0, 3.0
"""The marks: a part is held; it touches a wall; it also lies along the pipe."""

# --- posture ----------------------------------------------------------------------------------


def signal(index: float, numbers: Sequence[float], without: float) -> float:
    """Return the value of a signal, or what counts where there is none."""
    return numbers[int(index)] if index >= 0 else without


def heading_in_pipe(
    part: int, link: int, numbers: Sequence[float], chain: Rows, parts: Rows
) -> float:
    """Return a link's heading relative to the pipe axis at a clamped part, rad.

    It is positive towards side A, and NaN if an angle in between is unknown. The operations are
    those of :class:`~pirate_sm.core._geometry.chain.Chain` for a whole chain.
    """
    front, rear = int(parts[part][FRONT]), int(parts[part][REAR])
    heading, x, y = 0.0, 0.0, 0.0  # the front wheel is the origin
    for wheel in range(front, rear):
        if wheel > front:
            heading += signal(chain[wheel][ANGLE], numbers, 0.0)
        x -= chain[wheel][LENGTH] * cos(heading)
        y -= chain[wheel][LENGTH] * sin(heading)
    along, across = 0.0 - x, 0.0 - y
    length_m = sqrt(along * along + across * across)
    if length_m == 0.0:
        length_m = 1.0
    sides, aside_m = chain[front][SIDE] - chain[rear][SIDE], 0.0
    if sides != 0.0:
        aside_m = signal(parts[part][DIAMETER], numbers, nan) / 2 - parts[part][RADIUS]
    rise = sides * aside_m / length_m
    if isnan(rise):
        return nan
    turn = asin(max(-1.0, min(1.0, rise))) - atan2(across, along)
    heading, first = 0.0, min(front, len(chain) - 2)
    for wheel in range(first + 1, link + 1):
        heading += signal(chain[wheel][ANGLE], numbers, 0.0)
    for wheel in range(first, link, -1):
        heading -= signal(chain[wheel][ANGLE], numbers, 0.0)
    return heading + turn


def turned(x: float, y: float, angle_rad: float) -> tuple[float, float]:
    """Return a point rotated about the origin, from x to y."""
    c, s = cos(angle_rad), sin(angle_rad)
    return x * c - y * s, x * s + y * c


def force_in_pipe(
    part: int, numbers: Sequence[float], chain: Rows, parts: Rows, imu: Sequence[int]
) -> tuple[float, float, float]:
    """Return the specific force along the axis of a clamped part, towards its side B, and up.

    A clamped part holds the accelerometer's link obliquely: that angle is taken off.
    """
    if part < 0 or imu[LINK] < 0:
        return nan, nan, nan
    side_b, up = numbers[imu[SIDE_B]], numbers[imu[UP]]
    if imu[TWIST] >= 0 and parts[part][FRONT] > imu[LINK]:
        # The part is behind the roll joint, the accelerometer ahead of it.
        side_b, up = turned(side_b, up, -numbers[imu[TWIST]])
    turn = -heading_in_pipe(part, imu[LINK], numbers, chain, parts)
    ahead, side_b = turned(numbers[imu[AHEAD]], side_b, turn)
    return ahead, side_b, up


def is_gravity(ahead: float, side_b: float, up: float) -> bool:
    """Return whether a specific force is that of a robot at rest; False where it is unknown."""
    size = sqrt(ahead * ahead + side_b * side_b + up * up)
    return abs(size - GRAVITY_M_S2) <= _AT_REST * GRAVITY_M_S2


# --- the parts that hold ----------------------------------------------------------------------


def look_at_parts(numbers: Sequence[float], chain: Rows, parts: Rows, memory: list[float]) -> int:
    """Note what held parts show; return how many touch a wall, or -1 if none is held.

    ``AHEAD_M`` becomes the diameter at the foremost of them.
    """
    walled, foremost = -1, float(len(chain))
    memory[AHEAD_M] = nan
    for part in range(len(parts)):
        at, row = MARKS + PER_PART * part, parts[part]
        if memory[at] >= HELD:
            walled = max(walled, 0)
            is_open = abs(signal(row[APEX], numbers, 0.0)) > row[END_STOP] - _OPEN_RAD
            memory[at] = HELD if is_open else _WALLED
            memory[at + _SHOWN_M] = signal(row[DIAMETER], numbers, nan)
            memory[at + _HEADING] = heading_in_pipe(part, 0, numbers, chain, parts)
            if not is_open:
                walled += 1
                if row[FRONT] < foremost:
                    foremost, memory[AHEAD_M] = row[FRONT], memory[at + _SHOWN_M]
    return walled


def known(cell: int, least: float, memory: Sequence[float]) -> tuple[int, float, float, float]:
    """Return how many parts show a value, its sum, the least and the greatest.

    Args:
        cell: Which entry of each part.
        least: The mark of the parts that count, at least.
        memory: See :data:`MARKS`.
    """
    count, total, low, high = 0, 0.0, inf, -inf
    for at in range(MARKS, len(memory), PER_PART):
        value = memory[at + cell]
        if memory[at] >= least and not isnan(value):
            count, total, low, high = count + 1, total + value, min(low, value), max(high, value)
    return count, total, low, high


def mark_along(walled: int, memory: list[float]) -> int:
    """Mark the parts that lie along the pipe, because they show the last straight's diameter.

    While that diameter is unknown, two parts are compared with each other, and a single part does
    not count. Return how many parts there are.
    """
    count, straight_m = 0, memory[STRAIGHT_M]
    for at in range(MARKS, len(memory), PER_PART):
        agrees = abs(memory[at + _SHOWN_M] - straight_m) <= AGREEING * straight_m
        if memory[at] >= _WALLED and (agrees or (isnan(straight_m) and walled > 1)):
            memory[at] = _ALONG
            count += 1
    return count


def part_with_axis(least: float, memory: Sequence[float]) -> int:
    """Return the part that gives the pipe's axis, the last one if it still can; -1 without one."""
    last = int(memory[PART])
    if last >= 0 and memory[MARKS + PER_PART * last] >= least:
        return last
    for at in range(MARKS, len(memory), PER_PART):
        if memory[at] >= least:
            return (at - MARKS) // PER_PART
    return -1


# --- attitude ---------------------------------------------------------------------------------


def feel(force: tuple[float, float, float], now_s: float, memory: list[float]) -> None:
    """Remember a specific force in the axes of the pipe, if it is gravity's."""
    count = int(memory[COUNT])
    if is_gravity(*force):
        if count == SAMPLES:
            count -= 1
            for at in range(FORCES, FORCES + 3 * count):
                memory[at] = memory[at + 3]
        for axis in range(3):
            memory[FORCES + 3 * count + axis] = force[axis]
        memory[COUNT], memory[FELT_S] = count + 1, now_s
    elif not now_s - memory[FELT_S] < memory[LASTING_S]:
        memory[COUNT] = 0


def median(axis: int, memory: list[float]) -> float:
    """Return the median of a component of the forces."""
    count = int(memory[COUNT])
    for k in range(count):
        value, at = memory[FORCES + 3 * k + axis], _SORTED + k
        while at > _SORTED and memory[at - 1] > value:
            memory[at] = memory[at - 1]
            at -= 1
        memory[at] = value
    middle = _SORTED + count // 2
    return memory[middle] if count % 2 == 1 else (memory[middle - 1] + memory[middle]) / 2


def find_attitude(memory: list[float]) -> None:
    """Find roll and pitch (B-13 and B-14), rad; NaN where they are unknown."""
    memory[ROLL], memory[PITCH] = nan, nan
    if memory[COUNT] >= _LEAST_SAMPLES:
        along, side_b, up = median(0, memory), median(1, memory), median(2, memory)
        if sqrt(side_b * side_b + up * up) > _UPRIGHT * GRAVITY_M_S2:
            memory[ROLL] = atan2(-side_b, up)
        memory[PITCH] = atan2(along, hypot(side_b, up))


# --- all of it --------------------------------------------------------------------------------


def survey(
    now_s: float,
    numbers: Sequence[float],
    chain: Rows,
    parts: Rows,
    imu: Sequence[int],
    memory: list[float],
) -> None:
    """Survey the pipe.

    Args:
        now_s: The time.
        numbers: Every signal in SI.
        chain: See :data:`ANGLE`.
        parts: See :data:`APEX`.
        imu: See :data:`LINK`.
        memory: See :data:`PART`; changed. The marks of the parts that are held are not 0.
    """
    walled = look_at_parts(numbers, chain, parts, memory)
    shown, _, low_m, high_m = known(_SHOWN_M, _WALLED, memory)
    headed, _, left_rad, right_rad = known(_HEADING, _WALLED, memory)
    coplanar = imu[TWIST] < 0 or abs(numbers[imu[TWIST]]) <= _COPLANAR_RAD
    in_bend, segment = memory[IN_BEND] != 0.0, UNKNOWN
    if in_bend and memory[WORD] != 0.0:
        segment = JOINT
    elif walled == 0:
        segment = OUT
    elif walled > 0 and coplanar and right_rad - left_rad > _TURNED_RAD:
        segment = JOINT
    elif walled > 0 and not in_bend:
        segment = STRAIGHT
    straight, along = segment == STRAIGHT, mark_along(walled, memory)
    steps = straight and high_m - low_m > STEP * high_m and shown == headed == walled
    if not (steps and right_rad - left_rad <= _ALONG_RAD):
        memory[AHEAD_M] = nan
    counting = _WALLED if straight else _ALONG
    part = part_with_axis(_ALONG if along > 0 else counting, memory)
    if part != int(memory[PART]):
        memory[COUNT] = 0
    feel(force_in_pipe(part, numbers, chain, parts, imu), now_s, memory)
    find_attitude(memory)
    # A part that stands across a bend shows a diameter that is not the pipe's.
    shown, sum_m, low_m, high_m = known(_SHOWN_M, counting, memory)
    agree = shown > 0 and not high_m - low_m > AGREEING * high_m
    memory[DIAMETER_M] = sum_m / shown if agree else nan
    if straight and agree:
        memory[STRAIGHT_M] = memory[DIAMETER_M]
    memory[SEGMENT], memory[PART], memory[DUE_S] = segment, part, now_s + SURVEY_EVERY_S


def has_moved(old: float, new: float, noise: float, turn: float) -> bool:
    """Return whether a value has changed by more than noise, or became known or unknown.

    Whole turns do not count, unless a turn is 0.
    """
    if isnan(old) or isnan(new):
        return isnan(old) != isnan(new)
    away = new - old
    if turn > 0.0:
        away -= turn * round(away / turn)
    return abs(away) > noise


def is_news(memory: Sequence[float]) -> bool:
    """Return whether what was found may be reported, where the joint around the robot is not.

    A step of the diameter may be a joint. The noise of the pitch is a little less than that of a
    report, as compiled code may round `hypot` differently.
    """
    return (
        memory[SEGMENT] != memory[SAID]
        or not isnan(memory[AHEAD_M])
        or has_moved(memory[SAID + 1], memory[ROLL], NOISE_RAD, 2 * pi)
        or has_moved(memory[SAID + 2], memory[PITCH], NOISE_RAD - 1e-9, 0.0)
        or has_moved(memory[SAID + 3], memory[DIAMETER_M], NOISE_M, 0.0)
    )
