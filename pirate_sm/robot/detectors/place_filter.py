"""Filter the positions of wheels, and find the word that holds there, by plain numbers.

This is plain Python for detectors, and the simulator compiles the same source, as it does with
:mod:`pirate_sm.core._engine.sensing.evaluator`: floats, integers and sequences of them, and a
function comes after those that it calls. NaN is unknown.

A look is a row: its time, then the position of each wheel along the pipe. `work` is three rows as
long as there are looks.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from math import isnan, nan
from typing import TypeAlias

Rows: TypeAlias = Sequence[Sequence[float]]
Work: TypeAlias = Sequence[MutableSequence[float]]

WINDOW_S = 0.4
"""Time over which a position is filtered [decided]: 40 mm of travel at 0.1 m/s."""

SLACK_M = 0.01
"""A word stays valid until its wheel is this far before the point, so that noise does not switch it
on and off."""

FORGOTTEN_M = 0.25
"""The last word of a bend ends this far beyond its point."""


def median_of(values: MutableSequence[float], count: int) -> float:
    """Return the median of the first values, which are sorted; 0 for none."""
    for i in range(1, count):
        value, k = values[i], i
        while k > 0 and values[k - 1] > value:
            values[k] = values[k - 1]
            k -= 1
        values[k] = value
    if count == 0:
        return 0.0
    middle = count // 2
    return values[middle] if count % 2 == 1 else (values[middle - 1] + values[middle]) / 2


def line_of(wheel: int, count: int, looks: Rows, work: Work) -> int:
    """Write when a wheel's position was known, and where it was; return how often it was."""
    times_s, places_m, known = work[0], work[1], 0
    for i in range(count):
        if not isnan(looks[i][wheel + 1]):
            times_s[known], places_m[known] = looks[i][0], looks[i][wheel + 1]
            known += 1
    return known


def slope_of(known: int, work: Work) -> float:
    """Return the median slope of a line, m/s, over pairs half of it apart (Theil and Sen)."""
    times_s, places_m, slopes = work[0], work[1], work[2]
    half, pairs = known // 2, 0
    for i in range(known - half):
        if times_s[i + half] > times_s[i]:
            passed_s = times_s[i + half] - times_s[i]
            slopes[pairs] = (places_m[i + half] - places_m[i]) / passed_s
            pairs += 1
    return median_of(slopes, pairs)


def place_of(wheel: int, driven: bool, count: int, looks: Rows, work: Work) -> float:
    """Return the filtered position of a wheel at the last look, m; NaN if that did not see it.

    A driven wheel is on the line through its positions. One that is not driven stands at their
    median, because it does not move by itself.
    """
    if isnan(looks[count - 1][wheel + 1]):
        return nan
    known = line_of(wheel, count, looks, work)
    slope = slope_of(known, work) if driven else 0.0
    times_s, places_m, moved_m = work[0], work[1], work[2]
    for i in range(known):
        moved_m[i] = places_m[i] + slope * (looks[count - 1][0] - times_s[i])
    return median_of(moved_m, known)


def beyond_m(
    number: int, bend: int, direction: float, places_m: Sequence[float], points: Rows, bends: Rows
) -> float:
    """Return how far the wheel of a word is beyond the point where the word begins, m.

    Args:
        number: The word's, which is that of its point.
        bend: The bend's.
        direction: In which the robot travels: 1 forward, -1 backward.
        places_m: The filtered position of the wheel of each point.
        points: See `WordWatch` in `core/_model/whereabouts.py`; so for ``bends``.
        bends: The bends.
    """
    beyond = direction * (places_m[number] - bends[bend][0]) + points[number][1]
    return beyond + (bends[bend][1] if number == len(points) - 1 else -bends[bend][1])


def word_at(
    before: int, direction: float, places_m: Sequence[float], points: Rows, bends: Rows
) -> int:
    """Return the number of the word that holds; -1 for none, or where a position is unknown.

    Args:
        before: That of the word that held.
        direction: In which the robot travels; 0 before wheels are driven.
        places_m: As for :func:`beyond_m`; so for ``points`` and ``bends``.
        points: The farthest first.
        bends: The bends.
    """
    if direction == 0:
        return -1
    for bend in range(len(bends)):
        for number in range(len(points)):
            beyond = beyond_m(number, bend, direction, places_m, points, bends)
            if isnan(beyond):
                return -1
            if beyond >= (-SLACK_M if number == before else 0.0):
                if beyond < FORGOTTEN_M:
                    return number
                break
    return -1
