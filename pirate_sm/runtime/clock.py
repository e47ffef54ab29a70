"""The wall clock, behind a Protocol so that tests can bring their own."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Measures seconds from an arbitrary start, and waits."""

    def now(self) -> float:
        """Return the time in s; it never goes back."""
        ...

    def sleep(self, seconds: float) -> None:
        """Wait this many seconds; a signal handler may run meanwhile."""
        ...


class WallClock:
    """The monotonic clock of this machine, which changes of the date do not affect."""

    # Class attributes, to save a call: the loop reads the time at every frame.
    now = staticmethod(time.perf_counter)
    sleep = staticmethod(time.sleep)
