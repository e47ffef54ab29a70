"""Holds mission time to a multiple of wall-clock time."""

from __future__ import annotations

import time
from collections.abc import Callable
from math import inf
from typing import Protocol

SLICE_S = 0.004
"""Longest sleep, so that a request to stop, from any thread, waits no longer than this."""

FORGIVEN_LAG_S = 0.5
"""A run this far behind (a suspended process, a slow machine) does not catch up."""


class Pacer:
    """Holds a run to ``factor`` mission seconds per second of the wall clock; infinite: no waiting.

    It begins now, at mission time ``mission_s``.
    """

    def __init__(self, factor: float, clock: Clock, mission_s: float = 0.0) -> None:
        self._wanted = factor
        self._factor = factor
        self._clock = clock
        self._wall_s = clock.now()
        self._mission_s = mission_s

    @property
    def waits(self) -> bool:
        """Whether mission time is held back at all."""
        return self._factor != inf

    def limit(self, factor: float, mission_s: float) -> None:
        """From this mission time on run at ``factor``, or at the user's factor if that is lower."""
        factor = min(factor, self._wanted)
        if factor != self._factor:
            self._factor = factor
            self._anchor(mission_s)

    def release(self) -> None:
        """Do not hold mission time back any more."""
        self._wanted = self._factor = inf

    def wait_until(self, mission_s: float, cut_short: Callable[[], bool]) -> None:
        """Wait until the wall clock has reached this mission time or ``cut_short`` returns true.

        ``cut_short`` is called before every slice of sleep, so it may do small work too.
        """
        due_s = self._wall_s + (mission_s - self._mission_s) / self._factor
        while (left_s := due_s - self._clock.now()) > 0:
            if cut_short():
                return
            self._clock.sleep(min(left_s, SLICE_S))
        if left_s < -FORGIVEN_LAG_S:
            self._anchor(mission_s)

    def _anchor(self, mission_s: float) -> None:
        self._wall_s = self._clock.now()
        self._mission_s = mission_s


class Clock(Protocol):
    """Measures seconds from an arbitrary start, and waits."""

    def now(self) -> float:
        """Return the time in s; it never goes back."""

    def sleep(self, seconds: float) -> None:
        """Wait this many seconds; a signal handler may run meanwhile."""


class WallClock:
    """The monotonic clock of this machine, which changes of the date do not affect."""

    # Class attributes, to save a call: the loop reads the time at every frame.
    now = staticmethod(time.perf_counter)
    sleep = staticmethod(time.sleep)
