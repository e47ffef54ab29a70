"""Holds mission time to a multiple of the wall's time."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

from pirate_sm.runtime.clock import Clock

SLICE_S = 0.04
"""Longest sleep: after a signal the loop looks up this late at most."""

FORGIVEN_LAG_S = 0.5
"""A run this far behind (a suspended process, a slow machine) does not hurry to catch up."""


class Pacer:
    """Holds a run to ``factor`` mission seconds per second of the wall; infinite never waits.

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
        """Run at ``factor`` from this mission time on, or as wanted where that is less."""
        factor = min(factor, self._wanted)
        if factor != self._factor:
            self._factor = factor
            self._anchor(mission_s)

    def release(self) -> None:
        """Hold nothing back from now on."""
        self._wanted = self._factor = inf

    def wait_until(self, mission_s: float, cut_short: Callable[[], bool]) -> None:
        """Wait until the wall's clock has come to this mission time, or ``cut_short`` returns True.

        ``cut_short`` is asked before every slice of sleep, so it may do small work too.
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
