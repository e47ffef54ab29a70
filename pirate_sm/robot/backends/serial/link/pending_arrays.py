"""Arrays on their way to the device: wanted, being written, written without an answer."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

from pirate_sm.robot.backends.serial.link.wire_slots import Integers


@dataclass
class WantedArray:
    """An array that should come into force."""

    setpoint_id: int
    counts: Integers
    since_s: float


@dataclass
class ArrayUnderWay:
    """An array that is being written.

    Attributes:
        reported: Its result has been reported; only its last copy still has to be confirmed.
        needed: It must be confirmed again, because the device may have forgotten it.
        again: It must be written again.
    """

    order: WantedArray
    began_s: float
    reported: bool = False
    needed: bool = False
    sent_s: float = -inf
    numbers: list[int] = field(default_factory=list)
    again: bool = True


class Unanswered(NamedTuple):
    """A writing whose echo nothing waits for, but which still measures the line.

    Attributes:
        at_s: When it was written.
        overtaken: The array that a newer one has replaced; None for a refresh.
    """

    at_s: float
    overtaken: ArrayUnderWay | None = None
