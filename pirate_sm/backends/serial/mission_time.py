"""Mission time on a serial link, which stands still while the link is silent."""

from __future__ import annotations

from math import inf

from pirate_sm.backends.serial.link.exchange import Exchange


class MissionTime:
    """Counts mission time by the clock of the port.

    Attributes:
        now_s: Mission time reached.
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self._zero_s = 0.0
        self._held_s = inf
        self._late = False

    def begin(self, now: float) -> None:
        """Let mission time begin at this time of the clock."""
        self._zero_s = now

    def deadline_s(self, until_s: float, look_up_s: float) -> float:
        """Return until when to wait by the clock: for a mission time, or for ``look_up_s``."""
        return look_up_s if self._held_s < inf else min(self._zero_s + until_s, look_up_s)

    def follow(self, exchange: Exchange, now: float) -> None:
        """Stop mission time while the mission is held.

        It catches up with a silence that was none, but for what this program stood still for in it,
        and leaves out one that is reported as a fault.
        """
        outage = exchange.outage
        self._zero_s += exchange.take_left_out_s()
        if outage is not None:
            self._held_s = min(self._held_s, outage.since_s)
        elif self._held_s < inf:
            if exchange.brief:
                self._late = True
            else:
                self._zero_s += now - self._held_s
            self._held_s = inf

    def reach(self, now: float, until_s: float) -> bool:
        """Advance mission time to this time of the clock, at most to ``until_s``.

        Returns:
            Whether events of this moment may be reported; else mission time still catches up.
        """
        running_s = min(now, self._held_s)
        now_s = running_s - self._zero_s
        # Not `now_s` alone, which rounding may leave a hair before `until_s`.
        self.now_s = max(self.now_s, min(now_s, until_s))
        if running_s >= self._zero_s + until_s:
            self.now_s = until_s
        if self._late and now_s > until_s:
            return False
        self._late = False
        return True
