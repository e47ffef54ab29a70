"""Filters positions: a robust line through recent positions while wheels are driven."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import inf, isnan, nan

WINDOW_S = 0.4
"""Time over which a position is filtered [decided]: 40 mm of travel at 0.1 m/s."""


_OLDEST_S = 0.6
"""A position older than this is unknown [decided]: at 0.1 m/s the robot is 60 mm farther."""


class Tracker:
    """Remembers the positions of the wheels in the last ``WINDOW_S``."""

    def __init__(self) -> None:
        self._seen: deque[tuple[float, tuple[float, ...]]] = deque()
        self._driven = False
        self._changed_s = -inf

    def see(
        self,
        time_s: float,
        places_m: Sequence[float] | None,
        *,
        driven: bool,
        seen_s: float | None = None,
    ) -> None:
        """Take in the positions of the wheels.

        Args:
            time_s: Time, not earlier than in any earlier call.
            places_m: Position of each wheel along the pipe, NaN if unknown; None: nothing new.
            driven: Whether wheels are driven. When this changes, earlier positions are forgotten.
            seen_s: When the wheels were there; by default now. Positions from before wheels began
                or ceased to be driven are ignored.
        """
        self._now_s = time_s
        if driven != self._driven:
            self._seen.clear()
            self._driven, self._changed_s = driven, time_s
        seen_s = time_s if seen_s is None else seen_s
        if places_m is None or seen_s < self._changed_s:
            return
        self._seen.append((seen_s, tuple(places_m)))
        while self._seen[0][0] < seen_s - WINDOW_S:
            self._seen.popleft()

    @property
    def seen(self) -> Sequence[tuple[float, tuple[float, ...]]]:
        """Return times and positions in the window."""
        return self._seen

    @property
    def driven(self) -> bool:
        """Return whether wheels were driven when it last saw something."""
        return self._driven

    def place(self, wheel: int) -> float:
        """Return the filtered position of a wheel now, m; NaN if its last position is unknown.

        A driven wheel is on the line through its recent positions, whose slope is the median of
        slopes (Theil and Sen, over pairs half the window apart). From the last position on it moves
        as most wheels do: along the pipe a wheel that cuts a corner goes faster for a moment. A
        wheel that is not driven stands at the median of its positions, because it does not move by
        itself.
        """
        if not self._fresh or isnan(self._seen[-1][1][wheel]):
            return nan
        latest_s = self._seen[-1][0]
        seen = self._of(wheel)
        slope = self._slope(seen) if self._driven else 0.0
        place_m = _median([place + slope * (latest_s - at) for at, place in seen])
        if not self._driven:
            return place_m
        return place_m + self._speed() * (self._now_s - latest_s)

    def speed(self) -> float:
        """Return the speed of the robot along the pipe in the window, m/s, positive onwards.

        It is the median of the slopes of the wheels' lines; NaN without two positions.
        """
        return self._speed() if self._fresh and len(self._seen) > 1 else nan

    @property
    def _fresh(self) -> bool:
        return bool(self._seen) and self._seen[-1][0] >= self._now_s - _OLDEST_S

    def _of(self, wheel: int) -> list[tuple[float, float]]:
        return [(at, places[wheel]) for at, places in self._seen if not isnan(places[wheel])]

    def _speed(self) -> float:
        lines = [self._of(wheel) for wheel in range(len(self._seen[-1][1]))]
        return _median([self._slope(line) for line in lines if len(line) > 1])

    @staticmethod
    def _slope(seen: Sequence[tuple[float, float]]) -> float:
        pairs = zip(seen, seen[len(seen) // 2 :], strict=False)
        return _median([(b - a) / (tb - ta) for (ta, a), (tb, b) in pairs if tb > ta])


def _median(values: list[float]) -> float:
    """Return the median; 0 for no values."""
    values.sort()
    count = len(values)
    if not count:
        return 0.0
    middle = count // 2
    return values[middle] if count % 2 else (values[middle - 1] + values[middle]) / 2
