"""How the firmware reads frames: byte by byte, with a deadline, without going back.

Unlike :class:`pirate_sm.robot.rosserial.frames.Decoder` it loses the frame that follows a damaged
one, as the Arduino client does.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum, auto

from pirate_sm.robot.rosserial.frames import SYNC, SerialFrame

# A frame that is incomplete this long after its first byte is given up.
_PATIENCE_S = 0.020
_SYNC, _REVISION = SYNC


class _At(Enum):
    SYNC = auto()
    REVISION = auto()
    LENGTH_LOW = auto()
    LENGTH_HIGH = auto()
    LENGTH_CHECK = auto()
    TOPIC_LOW = auto()
    TOPIC_HIGH = auto()
    PAYLOAD = auto()
    CHECK = auto()


_NEXT_OF_HEAD = {
    _At.LENGTH_LOW: _At.LENGTH_HIGH,
    _At.LENGTH_HIGH: _At.LENGTH_CHECK,
    _At.TOPIC_LOW: _At.TOPIC_HIGH,
}


class Reception:
    """Takes bytes one at a time and drops damaged frames silently.

    A damaged frame may swallow the beginning of the next frame, which is then lost as well.

    Attributes:
        dropped: Frames that were begun and given up.
    """

    def __init__(self) -> None:
        self.dropped = 0
        self._at = _At.SYNC
        self._deadline_s = 0.0
        self._sum = 0
        self._word = 0
        self._length = 0
        self._topic = 0
        self._payload = bytearray()

    def feed(self, arrivals: Iterable[tuple[int, float]]) -> list[SerialFrame]:
        """Return the frames that these bytes complete.

        Args:
            arrivals: Bytes with the time at which each arrived, s.
        """
        found: list[SerialFrame] = []
        for byte, at_s in arrivals:
            if self._at is not _At.SYNC and at_s > self._deadline_s:
                self._give_up()
            if self._at is _At.PAYLOAD:  # as for most bytes
                self._pay(byte)
                continue
            if self._at is _At.SYNC:
                self._deadline_s = at_s + _PATIENCE_S
            frame = self._take(byte)
            if frame is not None:
                found.append(frame)
        return found

    def _give_up(self) -> None:
        self.dropped += self._at is not _At.REVISION
        self._at = _At.SYNC

    def _take(self, byte: int) -> SerialFrame | None:
        match self._at:
            case _At.SYNC:
                self._at = _At.REVISION if byte == _SYNC else _At.SYNC
            case _At.REVISION:
                self._at = _At.LENGTH_LOW if byte == _REVISION else _At.SYNC
                self._sum = 0
            case _At.CHECK:
                return self._end(byte)
            case _:
                self._head(byte)
        return None

    def _pay(self, byte: int) -> None:
        """Take one byte of the payload."""
        self._sum += byte
        self._payload.append(byte)
        if len(self._payload) == self._length:
            self._at = _At.CHECK

    def _head(self, byte: int) -> None:
        """Take one byte of length or topic."""
        self._sum += byte
        match self._at:
            case _At.LENGTH_LOW | _At.TOPIC_LOW:
                self._word = byte
                self._at = _NEXT_OF_HEAD[self._at]
            case _At.LENGTH_HIGH:
                self._length = self._word | byte << 8
                self._at = _At.LENGTH_CHECK
            case _At.LENGTH_CHECK if self._sum % 256 == 255:
                self._at, self._sum = _At.TOPIC_LOW, 0
            case _At.TOPIC_HIGH:
                self._topic = self._word | byte << 8
                self._payload.clear()
                self._at = _At.PAYLOAD if self._length else _At.CHECK
            case _:
                self._give_up()

    def _end(self, byte: int) -> SerialFrame | None:
        if (self._sum + byte) % 256 != 255:
            self._give_up()
            return None
        self._at = _At.SYNC
        return SerialFrame(self._topic, bytes(self._payload))
