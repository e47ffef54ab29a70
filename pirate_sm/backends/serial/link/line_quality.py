"""The quality of the line: what is lost, what comes damaged, how long an echo takes."""

from __future__ import annotations

from collections import deque
from math import ceil, inf, log, sqrt
from typing import NamedTuple

_BAD = 0.25
"""Where more than this share is lost, the echo of not even the first writing is waited for."""

_LOSS_GAIN = 1 / 16
_NOISE_BYTES = 2000
"""The share of damaged bytes is taken over this many: half a second of a busy line."""

# How the time to wait for an echo follows what echoes have taken, as TCP's does (RFC 6298).
_MEAN_GAIN = 1 / 8
_SPREAD_GAIN = 1 / 4
_SPREADS = 4.0
_MARGIN_S = 0.01

_TRIP_RISK = 1e-4
"""Refreshes come so often that the switch trips with this chance after an array that arrived."""

_MOST_LOST = 0.99


class Refreshing(NamedTuple):
    """How the array in force is repeated for the firmware's dead man's switch.

    Attributes:
        every_s: After this long without a writing; infinite: never.
        stop_after_s: The switch trips after this long without an array; infinite: there is none.
    """

    every_s: float = inf
    stop_after_s: float = inf

    def interval_s(self, lost: float, least_s: float) -> float:
        """Return how long after a writing the array in force is to be repeated.

        Args:
            lost: Share of arrays that do not arrive.
            least_s: The least time between two copies of one array.
        """
        if lost <= 0 or self.stop_after_s == inf:
            return self.every_s
        needed = ceil(log(_TRIP_RISK) / log(min(lost, _MOST_LOST)))
        return min(self.every_s, max(self.stop_after_s / needed, least_s))


NEVER = Refreshing()


class LineQuality:
    """Measures the line by the echoes of arrays and by the bytes of all that comes.

    Args:
        echo_within_s: What an echo takes until any has been seen.

    Attributes:
        round_trips: What the last echoes have taken, s.
    """

    def __init__(self, echo_within_s: float) -> None:
        self._longest_s = echo_within_s
        self._mean_s = self._spread_s = echo_within_s / 2
        self._loss = self._noise = 0.0
        self._losses = 1
        self.round_trips: deque[float] = deque(maxlen=1000)

    @property
    def bad(self) -> bool:
        """Whether so much is lost that no single writing can be relied upon.

        Echoes that do not come tell it, and so do the bytes of all that comes, long before the
        first array is written.
        """
        return self._worst > _BAD

    @property
    def lost_one_way(self) -> float:
        """Share of frames lost one way, if the line loses as many the other way."""
        return 1 - sqrt(1 - self._worst)

    @property
    def patience_s(self) -> float:
        """How long to wait for an echo until it is as good as lost."""
        return min(self._longest_s, self._mean_s + _SPREADS * self._spread_s + _MARGIN_S)

    @property
    def _worst(self) -> float:
        # A byte may be known to be damaged long after it came, so the noise may exceed 1.
        return min(max(self._loss, self._noise), _MOST_LOST)

    def learn(self, took_s: float) -> None:
        """Take in that an echo has taken so long."""
        self.round_trips.append(took_s)
        self._spread_s += _SPREAD_GAIN * (abs(took_s - self._mean_s) - self._spread_s)
        self._mean_s += _MEAN_GAIN * (took_s - self._mean_s)

    def lose(self, share: float) -> None:
        """Take in that this share of the last writings was not echoed."""
        self._losses += 1
        self._loss += max(_LOSS_GAIN, 1 / self._losses) * (share - self._loss)

    def listened(self, received: int, damaged: int) -> None:
        """Take in how many bytes have come lately and how many of them belonged to no frame."""
        if received:
            part = min(1.0, received / _NOISE_BYTES)
            self._noise += part * (damaged / received - self._noise)
