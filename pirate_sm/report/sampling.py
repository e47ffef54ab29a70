"""Values over time, and no more of them than can be seen."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from math import isnan, nan

from pirate_sm.report.model import Series

MOST_POINTS = 4_000
"""A screen has fewer columns; a run of ten minutes has about as many frames of each board."""


class Samples:
    """What each of some numbers was, whenever it was told or changed."""

    def __init__(self, count: int) -> None:
        self._times: list[list[float]] = [[] for _ in range(count)]
        self._values: list[list[float]] = [[] for _ in range(count)]
        self._last: tuple[float, ...] = (nan,) * count

    def take(self, at_s: float, numbers: tuple[float, ...], told: Sequence[int] = ()) -> None:
        """What was told, and what is different, has been noted.

        Args:
            at_s: When; does not go back.
            numbers: All of them, NaN where unknown.
            told: Indexes of those that were measured at this moment, whether new or not.
        """
        if numbers is self._last:
            return
        changed = {
            index
            for index, (old, new) in enumerate(zip(self._last, numbers, strict=True))
            if old != new and not (isnan(old) and isnan(new))
        }
        for index in changed.union(told):
            self._times[index].append(at_s)
            self._values[index].append(numbers[index])
        self._last = numbers

    def series(
        self,
        index: int,
        name: str,
        *,
        scale: float = 1.0,
        stepped: bool = False,
        main: bool = False,
        until_s: float | None = None,
    ) -> Series:
        """One of the numbers as a curve.

        Args:
            index: Which.
            name: What it is called.
            scale: From SI to the unit of the chart.
            stepped: As in the curve.
            main: As in the curve.
            until_s: Until when the last value held; None: only then.
        """
        times, values = list(self._times[index]), [v * scale for v in self._values[index]]
        if until_s is not None and times and times[-1] < until_s:
            times.append(until_s)
            values.append(values[-1])
        return Series(name, *thinned(times, values), stepped=stepped, main=main)


def thinned(
    times_s: Sequence[float], values: Sequence[float], most: int = MOST_POINTS
) -> tuple[list[float], list[float]]:
    """At most about so many points that look the same: of each bucket the least and the largest.

    The first and the last point stay, and a gap in what is known stays a gap.
    """
    count = len(times_s)
    if count <= most:
        return list(times_s), list(values)
    buckets = max(1, most // 3)
    kept = {0, count - 1}
    for number in range(buckets):
        bucket = range(count * number // buckets, count * (number + 1) // buckets)
        known = [index for index in bucket if not isnan(values[index])]
        if known:
            kept.add(min(known, key=values.__getitem__))
            kept.add(max(known, key=values.__getitem__))
        if len(known) < len(bucket):
            kept.add(next(index for index in bucket if isnan(values[index])))
    chosen = sorted(kept)
    return [times_s[index] for index in chosen], [values[index] for index in chosen]


def value_at(series: Series, at_s: float) -> float:
    """What the curve shows at a moment, between two points on the line that joins them.

    NaN before the first point and where nothing is known; before a gap and after the last point
    the value holds.
    """
    after = bisect_right(series.times_s, at_s)
    if after == 0:
        return nan
    before = series.values[after - 1]
    if after == len(series.times_s) or series.stepped:
        return before
    t0, t1, other = series.times_s[after - 1], series.times_s[after], series.values[after]
    return before if isnan(other) else before + (other - before) * (at_s - t0) / (t1 - t0)


def over(series: Series, change: Callable[[float, float], float], name: str) -> Series:
    """The curve with another value at each of its moments, made from time and value."""
    pairs = zip(series.times_s, series.values, strict=True)
    return Series(name, series.times_s, [change(at_s, value) for at_s, value in pairs])
