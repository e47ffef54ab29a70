"""Counts of what has happened on a link."""

from __future__ import annotations

from typing import NamedTuple


class Counts(NamedTuple):
    """Counts of what has happened on a link, for people.

    Attributes:
        dropped: Bytes that belonged to no frame.
        unreadable: Payloads that were not what their type says.
        strange: Frames and readings of nothing that is known.
        damaged: Echoes of something else than was written.
        repeats: Frames written again, since no echo came or the last copy was to be confirmed.
        refreshes: Frames written again to show the firmware's dead man's switch a sign of life.
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
