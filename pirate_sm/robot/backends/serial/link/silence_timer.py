"""Measures how long the other side has been silent while this program was awake."""

from __future__ import annotations

from math import inf

_OVERSLEPT = 2.0
"""A look that is this many intervals late shows that this process did not run in between."""

_LEAST_S = 1e-3
"""The shortest wait. Without it, rounding could make the last wait zero forever."""


class SilenceTimer:
    """Measures the silence of another process by looks at regular intervals.

    When the whole computer stands still, both processes do, and the first to wake would take the
    other for dead. A standstill of our own therefore restarts the measurement, once until the
    other side is heard: it gets the time for one more message.

    Args:
        nap_s: The longest time between two looks.
    """

    def __init__(self, nap_s: float) -> None:
        self._nap_s = nap_s
        self.hear(-inf)

    def hear(self, now: float) -> None:
        """Begin the measurement: the other side has been heard."""
        self._looked_s, self._waited_s, self._spared = now, 0.0, False

    def look(self, now: float) -> float:
        """Return how long the other side has been silent while we were awake, s."""
        gap_s, self._looked_s = now - self._looked_s, now
        if gap_s <= _OVERSLEPT * self._nap_s:
            self._waited_s += gap_s
        elif self._spared:
            self._waited_s += self._nap_s
        else:
            self._spared, self._waited_s = True, 0.0
        return self._waited_s

    def due_s(self, limit_s: float) -> float:
        """Return when to look next, to notice a silence of ``limit_s`` in time."""
        return self._looked_s + min(self._nap_s, max(_LEAST_S, limit_s - self._waited_s))
