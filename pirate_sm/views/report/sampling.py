"""Values over time, thinned to as many points as can be seen."""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from itertools import compress, count, groupby
from math import isnan, nan
from operator import ne

from pirate_sm.views.report.contents import Series

MOST_POINTS = 4_000
"""A screen has fewer columns; each board has about this many frames in ten minutes."""


_MOST_KEPT = 4 * MOST_POINTS
"""The most points of a number in memory, however long a run is."""

_EACH = 4
"""The points that represent a bucket: its least, its largest, a gap, its last."""

_FINEST_S = 1 / 64


class Curve:
    """A number over time, with few enough points in memory but the same look.

    When there are too many points, they are replaced by representative points of equal intervals.
    The resolution is the same all along the run, and coarser in a longer run.
    """

    def __init__(self) -> None:
        self._times, self._values = array("d"), array("d")
        self._bucket_s = 0.0

    def add(self, at_s: float, value: float) -> None:
        """Add a point; ``at_s`` must not decrease."""
        self._times.append(at_s)
        self._values.append(value)
        if len(self._times) > _MOST_KEPT:
            self._thin()

    def points(self) -> tuple[list[float], list[float]]:
        """Return times and values."""
        if self._bucket_s:
            self._thin()
        return list(self._times), list(self._values)

    def _thin(self) -> None:
        """Reduce the points to at most half of the largest number."""
        times, values = self._times, self._values
        span_s, bucket_s = times[-1] - times[0], self._bucket_s or _FINEST_S
        while span_s / bucket_s > _MOST_KEPT / 2 / _EACH - 2:
            bucket_s *= 2
        self._bucket_s = bucket_s
        buckets = groupby(range(len(times)), key=lambda index: times[index] // bucket_s)
        kept = [
            0,
            *(index for _, bucket in buckets for index in _representative(list(bucket), values)),
        ]
        if kept[1] == 0:
            del kept[0]
        self._times = array("d", [times[index] for index in kept])
        self._values = array("d", [values[index] for index in kept])


def _representative(bucket: Sequence[int], values: Sequence[float]) -> Iterable[int]:
    """Return the indices of the points that represent a bucket, in order."""
    known = [index for index in bucket if not isnan(values[index])]
    kept = {bucket[-1]}
    if known:
        kept.add(min(known, key=values.__getitem__))
        kept.add(max(known, key=values.__getitem__))
    if len(known) < len(bucket):
        kept.add(next(index for index in bucket if isnan(values[index])))
    return sorted(kept)


class Samples:
    """The values of several numbers, each noted when it was measured or changed."""

    def __init__(self, count: int) -> None:
        self._curves = [Curve() for _ in range(count)]
        self._last: tuple[float, ...] = (nan,) * count

    def take(self, at_s: float, numbers: tuple[float, ...], measured: Sequence[int] = ()) -> None:
        """Note the numbers that were measured now, and those that changed.

        Args:
            at_s: Time; does not decrease.
            numbers: All numbers, NaN if unknown.
            measured: Indices of those that were measured now, changed or not.
        """
        if numbers is self._last:
            return
        last = self._last
        changed = {
            index
            for index in compress(count(), map(ne, last, numbers))
            if not (isnan(last[index]) and isnan(numbers[index]))
        }
        for index in changed.union(measured):
            self._curves[index].add(at_s, numbers[index])
        self._last = numbers

    def series(
        self,
        index: int,
        name: str,
        *,
        scale: float = 1.0,
        stepped: bool = False,
        until_s: float | None = None,
    ) -> Series:
        """Return one of the numbers as a curve.

        Args:
            index: Index of the number.
            name: Name of the curve.
            scale: Factor from SI to the unit of the chart.
            stepped: As in the curve.
            until_s: Time up to which the last value held; None: no longer than its own time.
        """
        times, values = self._curves[index].points()
        values = [value * scale for value in values]
        if until_s is not None and times and times[-1] < until_s:
            times.append(until_s)
            values.append(values[-1])
        return Series(name, *thinned(times, values), stepped=stepped)


def thinned(
    times_s: Sequence[float], values: Sequence[float], most: int = MOST_POINTS
) -> tuple[list[float], list[float]]:
    """Return fewer points that look the same: the representative ones of each bucket.

    The first and the last point remain, and so does every gap.
    """
    size = len(times_s)
    if size <= most:
        return list(times_s), list(values)
    buckets = max(1, most // _EACH)
    kept = {0}
    for number in range(buckets):
        bucket = range(size * number // buckets, size * (number + 1) // buckets)
        kept.update(_representative(bucket, values))
    chosen = sorted(kept)
    return [times_s[index] for index in chosen], [values[index] for index in chosen]


def value_at(series: Series, at_s: float) -> float:
    """Return the value of the curve at a time, interpolated linearly between points.

    It is NaN before the first point and in a gap. Before a gap and after the last point the value
    holds.
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
    """Return the curve with each value replaced by a function of its time and value."""
    pairs = zip(series.times_s, series.values, strict=True)
    return Series(name, series.times_s, [change(at_s, value) for at_s, value in pairs])
