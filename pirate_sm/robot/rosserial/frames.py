"""Frames of rosserial, protocol revision 1, as bytes.

A frame is ``FF FE | length | check | topic | payload | check``, little-endian; each group with its
check sums to 255 modulo 256. An 8-bit sum misses some damage, so users of a payload must detect it
themselves.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

SYNC = b"\xff\xfe"
OVERHEAD_BYTES = 8
LONGEST_PAYLOAD = 512
"""The largest buffer of the Arduino client's default build."""

_HEAD = struct.Struct("<2sHB")
_TOPIC = struct.Struct("<H")
_BEFORE_PAYLOAD = _HEAD.size + _TOPIC.size


class SerialFrame(NamedTuple):
    """A payload on a topic; the topic is a number of this connection."""

    topic: int
    payload: bytes


def encode(topic: int, payload: bytes = b"") -> bytes:
    """Return the bytes of a frame, to write in one call.

    Raises:
        ValueError: The payload is too long for any receiver, or the topic is no 16-bit number.
    """
    if len(payload) > LONGEST_PAYLOAD or not 0 <= topic <= 0xFFFF:
        raise ValueError(f"no frame holds {len(payload)} bytes for topic {topic}")
    length = len(payload)
    head = _HEAD.pack(SYNC, length, 255 - (length % 256 + length // 256) % 256)
    body = _TOPIC.pack(topic) + payload
    return b"".join((head, body, bytes((255 - sum(body) % 256,))))


class Decoder:
    """Finds the frames in a stream of bytes, whatever is between them.

    This is the host's reader. The firmware's, which loses more, is
    :class:`pirate_sm.simulation.bay.node_handle.Reception`. A byte that begins no frame is dropped
    alone, and the search continues after it, so damage costs only the damaged frame. The result
    does not depend on how the stream is split.

    Attributes:
        dropped: Bytes that belonged to no frame.
        longest: The longest possible payload. A frame with a greater length is damaged: it is
            dropped at once, without waiting for its end.
    """

    def __init__(self) -> None:
        """Start with an empty stream."""
        self._pending = bytearray()
        self.dropped = 0
        self.longest = LONGEST_PAYLOAD

    def feed(self, data: bytes) -> list[SerialFrame]:
        """Return the frames that these bytes complete, oldest first."""
        pending = self._pending
        pending += data
        frames: list[SerialFrame] = []
        at = 0
        while True:
            start = pending.find(SYNC, at)
            if start < 0:
                # The last byte may be the first half of a frame's mark.
                start = len(pending) - pending.endswith(SYNC[:1])
                self.dropped += max(start - at, 0)
                at = max(start, at)
                break
            self.dropped += start - at
            at = start
            end = self._end(at)
            if end > len(pending):
                break
            if end:
                topic = _TOPIC.unpack_from(pending, at + _HEAD.size)[0]
                frames.append(SerialFrame(topic, bytes(pending[at + _BEFORE_PAYLOAD : end - 1])))
                at = end
            else:
                self.dropped += 1
                at += 1
        del pending[:at]
        return frames

    def _end(self, at: int) -> int:
        """Return the index of this frame's end; past the data if unknown yet, 0 if no frame."""
        pending = self._pending
        if len(pending) - at < _HEAD.size:
            return len(pending) + 1
        _, length, check = _HEAD.unpack_from(pending, at)
        if (length % 256 + length // 256 + check) % 256 != 255 or length > self.longest:
            return 0
        end: int = at + OVERHEAD_BYTES + length
        if end <= len(pending) and sum(pending[at + _HEAD.size : end]) % 256 != 255:
            return 0
        return end
