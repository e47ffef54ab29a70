"""Counts of what has happened on a link."""

from __future__ import annotations

from typing import NamedTuple


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
