"""What rosserial itself says: the reserved topics and how a device introduces its own."""

from __future__ import annotations

import struct
from typing import Literal, NamedTuple

REQUEST_TOPICS = 0
PUBLISHER = 0
SUBSCRIBER = 1
LOG = 7
TIME = 10
TX_STOP = 11

FIRST_OF_THE_DEVICE = 100
"""Below are reserved numbers: a device that offers a topic there is damaged or no rosserial."""

Direction = Literal["publishes", "takes"]

_TIME = struct.Struct("<II")
_U32 = struct.Struct("<I")
_I32 = struct.Struct("<i")


class TopicInfo(NamedTuple):
    """How the device introduces one of its topics.

    Attributes:
        number: What stands for the topic in frames, on this connection.
        direction: Whether the device sends or receives it.
        buffer_bytes: The longest payload that the device has room for.
    """

    number: int
    name: str
    type: str
    md5: str
    buffer_bytes: int
    direction: Direction


class LogLine(NamedTuple):
    """What the firmware says to people; levels as in ROS, 3 is an error, 4 fatal."""

    level: int
    text: str


def read_topic(frame_topic: int, payload: bytes) -> TopicInfo | None:
    """The introduction in this payload; None where it is none.

    Args:
        frame_topic: ``PUBLISHER`` or ``SUBSCRIBER``.
        payload: ``uint16 topic_id, string topic_name, string message_type, string md5sum,
            int32 buffer_size``.
    """
    try:
        number = int.from_bytes(payload[:2], "little")
        at = 2
        texts: list[str] = []
        for _ in range(3):
            text, at = _text(payload, at)
            texts.append(text)
        (room,) = _I32.unpack_from(payload, at)
    except (struct.error, UnicodeDecodeError, ValueError):
        return None
    if at + _I32.size != len(payload) or number < FIRST_OF_THE_DEVICE or room <= 0:
        return None
    direction: Direction = "publishes" if frame_topic == PUBLISHER else "takes"
    return TopicInfo(number, texts[0].lstrip("/"), texts[1], texts[2], room, direction)


def read_log(payload: bytes) -> LogLine | None:
    """The line in this payload, ``uint8 level, string msg``; None where there is none."""
    try:
        text, end = _text(payload, 1)
    except (struct.error, UnicodeDecodeError, ValueError):
        return None
    return LogLine(payload[0], text) if end == len(payload) else None


def time_payload(seconds: float) -> bytes:
    """The payload that answers a request for the time, seconds since 1970."""
    whole = int(seconds)
    return _TIME.pack(whole & 0xFFFFFFFF, int((seconds - whole) * 1e9))


def _text(payload: bytes, at: int) -> tuple[str, int]:
    (length,) = _U32.unpack_from(payload, at)
    end = at + _U32.size + length
    if end > len(payload):
        raise ValueError("the text is longer than the payload")
    return payload[at + _U32.size : end].decode(), end
