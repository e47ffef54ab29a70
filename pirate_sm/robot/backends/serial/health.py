"""The state of the link in numbers, for people."""

from __future__ import annotations

from math import inf, nan
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.exchange import Exchange

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
