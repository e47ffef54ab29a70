"""Conditions that a failed command has waited for in vain."""

from __future__ import annotations

from math import isinf, nan
from typing import Literal, NamedTuple, TypeAlias

Unknown: TypeAlias = Literal["", "silent", "implausible", "missing"]

HARDLY = 0.1
"""A signal that has come nearer by a smaller share of its way counts as not moved [decided]."""


class Unmet(NamedTuple):
    """A limit of one signal that did not hold when a command failed.

    Attributes:
        signal: Name of the signal.
        unit: Its SI unit; empty without one.
        least: The least value that was awaited, SI; ``-inf`` without a limit.
        most: The largest value; ``inf`` without a limit.
        magnitude: Whether the limits are those of the magnitude, whatever the sign.
        value: What the signal shows; NaN where it is unknown.
        age_s: How long ago its board last reported; infinite if it never did, NaN for a signal
            without a board.
        change: By how much the signal has changed since the command, or its present stage, began;
            NaN where it is unknown now or was unknown then.
        unknown: Why the value is unknown; empty where it is known. ``silent``: the board does not
            report. ``implausible``: its readings cannot be true. ``missing``: none of these.
        board: The board that reports the signal; empty without one.
    """

    signal: str
    unit: str
    least: float
    most: float
    magnitude: bool = False
    value: float = nan
    age_s: float = nan
    change: float = nan
    unknown: Unknown = ""
    board: str = ""

    @property
    def still_moves(self) -> bool:
        """Return whether the signal is a rate or a speed that should be smaller."""
        return self.unit.endswith("/s") and not self.unknown and not isinf(self.most - self.least)

    @property
    def hardly_moved(self) -> bool:
        """Return whether the signal has not come nearer to its limits by more than noise."""
        now, began = self.value, self.value - self.change
        if self.magnitude:
            now, began = abs(now), abs(began)
        return self._off(began) - self._off(now) < HARDLY * self._off(began)

    def _off(self, value: float) -> float:
        return max(self.least - value, value - self.most, 0.0)
