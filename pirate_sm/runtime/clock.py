"""The wall's clock, behind a Protocol so that tests bring their own."""

from __future__ import annotations

import time
from typing import Protocol


class Clock(Protocol):
    """Tells seconds from an arbitrary beginning and waits."""

    def now(self) -> float:
        """Return the time in s; it never goes back."""
        ...

    def sleep(self, seconds: float) -> None:
        """Wait for so many seconds; a signal handler may run meanwhile."""
        ...


class WallClock:
    """The clock that a person's watch agrees with, unmoved by changes of the date."""

    # The functions themselves: the loop asks for the time at every frame.
    now = staticmethod(time.perf_counter)
    sleep = staticmethod(time.sleep)
