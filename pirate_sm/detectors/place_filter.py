"""Filters positions: a robust line through recent positions while wheels are driven."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import isnan, nan

WINDOW_S = 0.4
"""Time over which a position is filtered [decided]: 40 mm of travel at 0.1 m/s."""


class Tracker:
    """Remembers the positions of the wheels in the last ``WINDOW_S``."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, tuple[float, ...]]] = deque()
        self._driven = False

    def see(self, time_s: float, places_m: Sequence[float], *, driven: bool) -> None:
        """Take in the positions of the wheels.

        Args:
            time_s: Time, not earlier than in any earlier call.
            places_m: Position of each wheel along the pipe; NaN if unknown.
            driven: Whether wheels are driven. When this changes, earlier positions are forgotten.
        """
        if driven != self._driven:
            self._seen.clear()
            self._driven = driven
        self._seen.append((time_s, tuple(places_m)))
        while self._seen[0][0] < time_s - WINDOW_S:
            self._seen.popleft()

    def place(self, wheel: int) -> float:
        """Return the filtered position of a wheel, m; NaN if its last position is unknown.

        A driven wheel is on the line through its recent positions, whose slope is the median of
        slopes (Theil and Sen, over pairs half the window apart). A wheel that is not driven stands
        at the median of its positions, because it does not move by itself.
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
    """Return the median; 0 for no values."""
    values.sort()
    count = len(values)
    if not count:
        return 0.0
    middle = count // 2
    return values[middle] if count % 2 else (values[middle - 1] + values[middle]) / 2
