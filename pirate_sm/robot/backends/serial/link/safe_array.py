"""The array that stops what the safe state stops and holds everything else."""

from __future__ import annotations

from collections.abc import Collection

from pirate_sm.robot.backends.serial.link.wire_slots import Integers
from pirate_sm.robot.rosserial.messages import SetpointCodec

SAFE_WIRE_ID = 0
"""The wire id of the safe array; no other array has it."""


class SafeArray:
    """Makes the payload of the safe array.

    Args:
        codec: The codec of arrays.
        zero: Slots that are zero in the safe state.
        slots: How many slots there are.

    Attributes:
        kept: One bit per slot that the firmware's dead man's switch keeps.
        held: Values to hold, where they differ from those in force.
        counts: The last safe array that was made.
    """

    def __init__(self, codec: SetpointCodec, zero: Collection[int], slots: int) -> None:
        self._codec = codec
        self._zero = frozenset(zero)
        self._source: Integers | None = None
        self._payload = b""
        self.kept = sum(1 << at for at in range(slots) if at not in self._zero)
        self.held: Integers | None = None
        self.counts: Integers = ()

    def payload(self, in_force: Integers) -> bytes:
        """Return the payload for the array in force."""
        source = self.held if self.held is not None else in_force
        if source is not self._source:  # cached, for it is needed at every turn
            self._source = source
            self.counts = tuple(0 if at in self._zero else each for at, each in enumerate(source))
            self._payload = self._codec.pack(SAFE_WIRE_ID, self.counts, self.kept)
        return self._payload
