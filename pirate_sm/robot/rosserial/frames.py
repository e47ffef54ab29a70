"""Frames of rosserial, protocol revision 1, as bytes, and its reserved topics with their payloads.

A frame is ``FF FE | length | check | topic | payload | check``, little-endian; each group with its
check sums to 255 modulo 256. An 8-bit sum misses some damage, so users of a payload must detect it
themselves.
"""

from __future__ import annotations

import struct
from typing import Literal, NamedTuple

# --- frames ---------------------------------------------------------------------------------------


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


# --- reserved topics ------------------------------------------------------------------------------


REQUEST_TOPICS = 0
PUBLISHER = 0
SUBSCRIBER = 1
PARAMETER = 6
LOG = 7
TIME = 10
TX_STOP = 11

FIRST_OF_THE_DEVICE = 100
"""Lower numbers are reserved: a device that offers one is damaged or does not speak rosserial."""

Direction = Literal["publishes", "takes"]

_TIME = struct.Struct("<II")
_U16 = struct.Struct("<H")
_U32 = struct.Struct("<I")
_I32 = struct.Struct("<i")

TIME_REQUEST = bytes(_TIME.size)
"""The payload with which a device asks for the time."""


class TopicInfo(NamedTuple):
    """A device's introduction of one of its topics.

    Attributes:
        number: Number of the topic in frames, on this connection.
        name: Name of the topic.
        type: Its message type, ``package/Type``.
        md5: ROS 1's checksum of the fields of the type.
        buffer_bytes: The longest payload that the device can hold.
        direction: Whether the device sends or receives it.
    """

    number: int
    name: str
    type: str
    md5: str
    buffer_bytes: int
    direction: Direction


class LogLine(NamedTuple):
    """A line of the firmware's log; levels as in ROS, 1 is information, 3 an error, 4 fatal."""

    level: int
    text: str


def read_topic(frame_topic: int, payload: bytes) -> TopicInfo | None:
    """Return the introduction in this payload; None if there is none.

    Args:
        frame_topic: ``PUBLISHER`` or ``SUBSCRIBER``.
        payload: ``uint16 topic_id, string topic_name, string message_type, string md5sum,
            int32 buffer_size``.
    """
    try:
        (number,) = _U16.unpack_from(payload)
        name, at = _read_text(payload, _U16.size)
        kind, at = _read_text(payload, at)
        md5, at = _read_text(payload, at)
        (room,) = _I32.unpack_from(payload, at)
    except (struct.error, UnicodeDecodeError, ValueError):
        return None
    if at + _I32.size != len(payload) or number < FIRST_OF_THE_DEVICE or room <= 0:
        return None
    direction: Direction = "publishes" if frame_topic == PUBLISHER else "takes"
    return TopicInfo(number, name.lstrip("/"), kind, md5, room, direction)


def topic_payload(info: TopicInfo) -> bytes:
    """Return the payload with which a device introduces a topic."""
    texts = b"".join(_text(each) for each in (info.name, info.type, info.md5))
    return _U16.pack(info.number) + texts + _I32.pack(info.buffer_bytes)


def read_log(payload: bytes) -> LogLine | None:
    """Return the line in this payload, ``uint8 level, string msg``; None if there is none."""
    try:
        text, end = _read_text(payload, 1)
    except (struct.error, UnicodeDecodeError, ValueError):
        return None
    return LogLine(payload[0], text) if end == len(payload) else None


def log_payload(line: LogLine) -> bytes:
    """Return the payload for a line of the log."""
    return bytes((line.level,)) + _text(line.text)


def time_payload(seconds: float) -> bytes:
    """Return the answer to a request for the time, seconds since 1970."""
    whole = int(seconds)
    return _TIME.pack(whole & 0xFFFFFFFF, int((seconds - whole) * 1e9))


def _text(text: str) -> bytes:
    raw = text.encode()
    return _U32.pack(len(raw)) + raw


def _read_text(payload: bytes, at: int) -> tuple[str, int]:
    (length,) = _U32.unpack_from(payload, at)
    end = at + _U32.size + length
    if end > len(payload):
        raise ValueError("the text is longer than the payload")
    return payload[at + _U32.size : end].decode(), end
