"""The state of a link in numbers: counts, the quality of the line, and a summary for people."""

from __future__ import annotations

from collections import deque
from math import ceil, inf, log, nan, sqrt
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.exchange import Exchange


# --- for people -----------------------------------------------------------------------------------


_NOTHING = "nothing comes from the robot"


class LinkHealth(NamedTuple):
    """What has happened on the link so far, and its state now.

    Attributes:
        received: Frames received. ``damaged`` is how many of them were unusable, including echoes
            of values that were not written.
        written: Arrays written; ``repeated`` is how many of them were repeats.
        dropped_bytes: Bytes that belonged to no frame.
        round_trip_s: Time from the last writing to its echo; NaN before the first echo.
        silent_s: How long nothing has been received; 0 while the link works.
        trouble: The present problem in words; empty if none.
        patience_s: How much longer the mission waits for the link; 0 while it works.
        stopped: Whether the robot has confirmed that it stopped, or has not been moved.
        trips: How often the firmware's dead man's switch has tripped, as far as reported.
        switch_stops_s: The length of a silence after which that switch has stopped the robot, if
            the controller still runs; infinite if none is fitted.
    """

    received: int
    damaged: int
    written: int
    repeated: int
    dropped_bytes: int
    round_trip_s: float
    silent_s: float
    trouble: str
    patience_s: float = 0.0
    stopped: bool = True
    trips: int = 0
    switch_stops_s: float = inf


def health_of(exchange: Exchange, now: float) -> LinkHealth:
    """Return the state of a link at this time of its port's clock."""
    counts, outage = exchange.counts, exchange.outage
    trips = exchange.link.quality.round_trips
    trouble, heard_s = "", now
    if outage is not None:
        trouble, heard_s = outage.gone or _NOTHING, outage.heard_s
    elif exchange.given_up:
        trouble, heard_s = _NOTHING, exchange.conversation.heard_s
    return LinkHealth(
        received=counts.frames,
        damaged=counts.unreadable + counts.strange + counts.damaged,
        written=counts.written,
        repeated=counts.repeats,
        dropped_bytes=counts.dropped,
        round_trip_s=trips[-1] if trips else nan,
        silent_s=now - heard_s,
        trouble=trouble,
        patience_s=max(exchange.gives_up_s - now, 0.0) if outage is not None else 0.0,
        stopped=exchange.stopped.confirmed,
        trips=counts.trips,
        switch_stops_s=exchange.switch_stops_s,
    )


# --- the line -------------------------------------------------------------------------------------


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


# --- counts ---------------------------------------------------------------------------------------


class Counts(NamedTuple):
    """Counts of what has happened on a link.

    Attributes:
        dropped: Bytes that belonged to no frame.
        unreadable: Payloads that do not fit their type.
        strange: Frames and readings of unknown topics, boards or channels.
        damaged: Echoes of values that were not written.
        repeats: Frames written again, because no echo came or the last copy needed confirming.
        refreshes: Frames written again as a sign of life for the firmware's dead man's switch.
        trips: How often the firmware has reported that its switch has tripped.
    """

    frames: int
    dropped: int
    unreadable: int
    strange: int
    written: int
    damaged: int
    repeats: int
    refreshes: int
    trips: int
