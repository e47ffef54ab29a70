"""The reserved topics of rosserial and their payloads."""

from __future__ import annotations

import struct
from typing import Literal, NamedTuple

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
