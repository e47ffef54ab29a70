"""The device's side of a rosserial conversation: what it says when, and what it takes."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import NamedTuple

from pirate_sm.bay.frames import BUFFER_SIZE, Frame

ASK_TOPICS = SAY_PUBLISHER = 0
SAY_SUBSCRIBER = 1
LOG = 7
TIME = 10
STOP = 11
FIRST_TOPIC = 100
SUBSCRIBERS = 25
"""Ids from ``FIRST_TOPIC`` on are subscribers'; publishers' follow after so many."""

INFO = 1
_PARAMETER = 6
_ASK_TIME_EVERY_S = 2.5
_FORGET_AFTER_S = 11.0


class Topic(NamedTuple):
    """A topic as the device announces it."""

    id: int
    name: str
    type: str
    md5: str


class Message(NamedTuple):
    """What goes into one frame."""

    topic: int
    payload: bytes


class Answer(NamedTuple):
    """What the device makes of a frame.

    Attributes:
        says: Messages to be sent, in order.
        delivered: For a subscriber: the receive buffer, which begins with the payload. Behind a
            payload that is too short stands what earlier ones left there.
        fault: What the host did wrong, empty for nothing.
    """

    says: tuple[Message, ...] = ()
    delivered: bytes | None = None
    fault: str = ""


class Conversation:
    """Silent until asked for its topics.

    Args:
        publishers: What the device sends, in the order in which it says so.
        subscribers: What it listens to.

    Attributes:
        configured: Whether it has been asked for its topics and its time is answered; if not, it
            publishes nothing.
    """

    def __init__(self, publishers: Sequence[Topic], subscribers: Sequence[Topic]) -> None:
        self.configured = False
        self._publishers = tuple(publishers)
        self._subscribers = tuple(subscribers)
        self._listening = frozenset(topic.id for topic in subscribers)
        self._buffer = bytearray(BUFFER_SIZE)
        self._asked_time_s = -math.inf
        self._heard_time_s = -math.inf

    def take(self, frame: Frame, now_s: float) -> Answer:
        """The frame has had its effect."""
        if frame.length > BUFFER_SIZE:
            return Answer(fault=f"a payload of {frame.length} bytes overwrites memory")
        self._buffer[: frame.length] = frame.payload
        if frame.topic == ASK_TOPICS:
            self.configured = True
            self._asked_time_s = self._heard_time_s = now_s
            return Answer(self._introduction())
        if frame.topic == TIME:
            self._heard_time_s = now_s
        elif frame.topic == STOP:
            self.configured = False
        elif frame.topic in self._listening:
            return Answer(delivered=bytes(self._buffer))
        elif frame.topic not in (_PARAMETER, LOG):
            return Answer(fault=f"nobody listens to id {frame.topic}: memory is overwritten")
        return Answer()

    def tick(self, now_s: float) -> tuple[Message, ...]:
        """What there is to say at this time; without time for too long it is unconfigured."""
        if now_s - self._heard_time_s > _FORGET_AFTER_S:
            self.configured = False
        if self.configured and now_s - self._asked_time_s >= _ASK_TIME_EVERY_S:
            self._asked_time_s = now_s
            return (_TIME_REQUEST,)
        return ()

    def _introduction(self) -> tuple[Message, ...]:
        return (
            _TIME_REQUEST,
            *(Message(SAY_PUBLISHER, topic_info(topic)) for topic in self._publishers),
            *(Message(SAY_SUBSCRIBER, topic_info(topic)) for topic in self._subscribers),
        )


_TIME_REQUEST = Message(TIME, bytes(8))


def topic_info(topic: Topic) -> bytes:
    """The payload that announces a topic."""
    return b"".join(
        (
            struct.pack("<H", topic.id),
            *(_string(text) for text in (topic.name, topic.type, topic.md5)),
            struct.pack("<i", BUFFER_SIZE),
        )
    )


def log_message(text: str, level: int = INFO) -> Message:
    """What a log line is sent as."""
    return Message(LOG, bytes((level,)) + _string(text))


def _string(text: str) -> bytes:
    raw = text.encode()
    return struct.pack("<I", len(raw)) + raw
