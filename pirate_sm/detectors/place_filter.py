"""Filters places: a robust line through the last moments, read off now while wheels are driven."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import isnan, nan

WINDOW_S = 0.4
"""How much of the past a place is taken from [decided]: 40 mm of way at 0.1 m/s."""


class Tracker:
    """Remembers where the wheels were seen in the last ``WINDOW_S``."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, tuple[float, ...]]] = deque()
        self._driven = False

    def see(self, time_s: float, places_m: Sequence[float], *, driven: bool) -> None:
        """Take in where the wheels have been seen.

        Args:
            time_s: When; not before that of any earlier call.
            places_m: The place of each wheel along the pipe; NaN where it is unknown.
            driven: Whether wheels are driven. What was seen before they began or ceased to be
                says nothing of what comes after.
        """
        if driven != self._driven:
            self._seen.clear()
            self._driven = driven
        self._seen.append((time_s, tuple(places_m)))
        while self._seen[0][0] < time_s - WINDOW_S:
            self._seen.popleft()

    def place(self, wheel: int) -> float:
        """Return where a wheel is now, m; NaN where it was not seen the last time.

        A driven wheel is on the line through the places where it was seen, whose slope is the
        median of slopes (Theil and Sen, over pairs that lie half the window apart). One that is
        not driven stands at the median of the places: it never moves by itself.
        """
        now_s, latest = self._seen[-1]
        if isnan(latest[wheel]):
            return nan
        seen = [(at, places[wheel]) for at, places in self._seen if not isnan(places[wheel])]
        slope = 0.0
        if self._driven and len(seen) > 1:
            half = len(seen) // 2
            pairs = zip(seen[:-half], seen[half:], strict=True)
            slope = _median([(b - a) / (tb - ta) for (ta, a), (tb, b) in pairs if tb > ta])
        return _median([place + slope * (now_s - at) for at, place in seen])


def _median(values: list[float]) -> float:
    """Return the median; 0 of no value."""
    values.sort()
    count = len(values)
    if not count:
        return 0.0
    middle = count // 2
    return values[middle] if count % 2 else (values[middle - 1] + values[middle]) / 2
