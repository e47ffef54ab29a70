"""The quality of the line: shares of lost frames and damaged bytes, time to an echo."""

from __future__ import annotations

from collections import deque
from math import ceil, inf, log, sqrt
from typing import NamedTuple

_BAD = 0.25
"""With more losses than this share, the next copy does not wait for an echo."""

_LOSS_GAIN = 1 / 16
_NOISE_BYTES = 2000
"""Bytes over which the share of damage is taken: half a second of a busy line."""

# The time to wait for an echo follows the measured times, as in TCP (RFC 6298).
_MEAN_GAIN = 1 / 8
_SPREAD_GAIN = 1 / 4
_SPREADS = 4.0
_MARGIN_S = 0.01

_TRIP_RISK = 1e-4
"""Refreshes are frequent enough that the switch trips with this chance after a received array."""

_MOST_LOST = 0.99


class Refreshing(NamedTuple):
    """How the array in force is repeated for the firmware's dead man's switch.

    Attributes:
        every_s: The array is repeated after this long without a writing; infinite: never.
        stop_after_s: The switch trips after this long without an array; infinite: no switch.
    """

    every_s: float = inf
    stop_after_s: float = inf

    def interval_s(self, lost: float, least_s: float) -> float:
        """Return the time from a writing to the repetition of the array in force.

        Args:
            lost: Share of arrays that are lost.
            least_s: The least time between two copies of one array.
        """
        if lost <= 0 or self.stop_after_s == inf:
            return self.every_s
        needed = ceil(log(_TRIP_RISK) / log(min(lost, _MOST_LOST)))
        return min(self.every_s, max(self.stop_after_s / needed, least_s))


NEVER = Refreshing()


class LineQuality:
    """Measures the line by the echoes of arrays and by all bytes received.

    Args:
        echo_within_s: The assumed time to an echo, until one has been measured.

    Attributes:
        round_trips: Times to the last echoes, s.
        received: Bytes received.
    """

    def __init__(self, echo_within_s: float) -> None:
        self._longest_s = echo_within_s
        self._mean_s = self._spread_s = echo_within_s / 2
        self._loss = self._noise = 0.0
        self._losses = 1
        self.received = 0
        self.round_trips: deque[float] = deque(maxlen=1000)

    @property
    def bad(self) -> bool:
        """Whether the losses are too high to rely on a single writing.

        Missing echoes show it, and so do damaged bytes, long before the first array is written.
        """
        return self._worst > _BAD

    @property
    def lost_one_way(self) -> float:
        """Share of frames lost one way, if both directions lose as many."""
        return 1 - sqrt(1 - self._worst)

    @property
    def patience_s(self) -> float:
        """How long to wait for an echo until it counts as lost."""
        return min(self._longest_s, self._mean_s + _SPREADS * self._spread_s + _MARGIN_S)

    @property
    def _worst(self) -> float:
        # Damage to a byte may be found long after its reception, so the noise may exceed 1.
        return min(max(self._loss, self._noise), _MOST_LOST)

    def learn(self, took_s: float) -> None:
        """Take in the time to an echo, s."""
        self.round_trips.append(took_s)
        self._spread_s += _SPREAD_GAIN * (abs(took_s - self._mean_s) - self._spread_s)
        self._mean_s += _MEAN_GAIN * (took_s - self._mean_s)

    def lose(self, share: float) -> None:
        """Take in the share of the last writings that was not echoed."""
        self._losses += 1
        self._loss += max(_LOSS_GAIN, 1 / self._losses) * (share - self._loss)

    def listened(self, received: int, damaged: int) -> None:
        """Take in how many bytes have come lately, and how many of them belonged to no frame."""
        self.received += received
        if received:
            part = min(1.0, received / _NOISE_BYTES)
            self._noise += part * (damaged / received - self._noise)
