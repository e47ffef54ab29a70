"""Finds the control changes in the bytes of a MIDI device."""

from __future__ import annotations

from typing import NamedTuple

_STATUS, _SYSTEM, _REALTIME = 0x80, 0xF0, 0xF8
_CONTROL_CHANGE = 0xB0


class ControlChange(NamedTuple):
    """A control has another value.

    Attributes:
        channel: MIDI channel, 1 to 16.
        number: Number of the control, 0 to 127.
        value: Its value, 0 to 127.
    """

    channel: int
    number: int
    value: int


class ControlChangeParser:
    """Takes bytes as they come, in pieces of any size (MIDI 1.0, detailed specification).

    A control change is a status byte ``0xB0 + channel``, a number and a value. Further pairs may
    follow without a status byte (running status). Single bytes from 0xF8 on may come between any
    two bytes and change nothing. All other messages are passed over.

    Attributes:
        others: How many messages of a channel were no control changes.
    """

    def __init__(self) -> None:
        self.others = 0
        self._channel = 0
        self._number = -1

    def take(self, data: bytes) -> list[ControlChange]:
        """Return the control changes that these bytes complete."""
        found = []
        for byte in data:
            if byte >= _REALTIME:
                continue
            if byte >= _STATUS:
                ours = byte & 0xF0 == _CONTROL_CHANGE
                self._channel = (byte & 0x0F) + 1 if ours else 0
                self._number = -1
                self.others += not ours and byte < _SYSTEM
            elif self._channel and self._number < 0:
                self._number = byte
            elif self._channel:
                found.append(ControlChange(self._channel, self._number, byte))
                self._number = -1
        return found
