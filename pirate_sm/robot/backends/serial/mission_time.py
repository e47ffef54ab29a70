"""Mission time on a serial link, which stands still while the link is silent."""

from __future__ import annotations

from math import inf

from pirate_sm.robot.backends.serial.link.exchange import Exchange


class MissionTime:
    """Derives mission time from the port's clock.

    Attributes:
        now_s: Mission time, s.
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self._zero_s = 0.0
        self._held_s = inf
        self._late = False

    def deadline_s(self, until_s: float, look_up_s: float) -> float:
        """Return the time of the clock until which to wait: a mission time, or ``look_up_s``."""
        return look_up_s if self._held_s < inf else min(self._zero_s + until_s, look_up_s)

    def follow(self, exchange: Exchange, now: float) -> None:
        """Stop mission time while the mission is held.

        After a brief silence it catches up, except for the time in which this program stood still.
        It leaves out a silence that is reported as a fault.
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

    def stand(self, now: float) -> None:
        """Go on from this time of the clock, and leave out what has passed before."""
        self._zero_s = min(now, self._held_s) - self.now_s
        self._late = False

    def reach(self, now: float, until_s: float) -> bool:
        """Advance mission time to this time of the clock, at most to ``until_s``.

        Returns:
            Whether events may be reported now; if not, mission time is still catching up.
        """
        running_s = min(now, self._held_s)
        now_s = running_s - self._zero_s
        # `now_s` alone is not enough: rounding may leave it just below `until_s`.
        self.now_s = max(self.now_s, min(now_s, until_s))
        if running_s >= self._zero_s + until_s:
            self.now_s = until_s
        if self._late and now_s > until_s:
            return False
        self._late = False
        return True
