"""The device's side of the rosserial protocol, as the Arduino client's node handle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from pirate_sm.rosserial.frames import LONGEST_PAYLOAD, Frame
from pirate_sm.rosserial.topics import (
    LOG,
    PARAMETER,
    PUBLISHER,
    REQUEST_TOPICS,
    SUBSCRIBER,
    TIME,
    TIME_REQUEST,
    TX_STOP,
    TopicInfo,
    topic_payload,
)

MOST_SUBSCRIBERS = 25
"""Numbers from ``FIRST_OF_THE_DEVICE`` on are subscribers'; publishers' follow after so many."""

_ASK_TIME_EVERY_S = 2.5
_FORGET_AFTER_S = 11.0


class Answer(NamedTuple):
    """What a frame makes the device do.

    Attributes:
        says: Frames to be sent, in order.
        delivered: For a subscriber: the receive buffer, which begins with the payload. Behind a
            payload that is too short stands what earlier ones left there.
        fault: What the host did wrong, empty for nothing.
    """

    says: tuple[Frame, ...] = ()
    delivered: bytes | None = None
    fault: str = ""


class NodeHandle:
    """Answers the host, and says nothing until it is asked for its topics.

    Args:
        publishers: What the device sends, in the order in which it says so.
        subscribers: What it listens to.

    Attributes:
        configured: Whether it has been asked for its topics and its time is answered; if not, it
            publishes nothing.
    """

    def __init__(self, publishers: Sequence[TopicInfo], subscribers: Sequence[TopicInfo]) -> None:
        self.configured = False
        self._publishers = tuple(publishers)
        self._subscribers = tuple(subscribers)
        self._listening = frozenset(topic.number for topic in subscribers)
        self._buffer = bytearray(LONGEST_PAYLOAD)
        self._asked_time_s = -math.inf
        self._heard_time_s = -math.inf

    def take(self, frame: Frame, now_s: float) -> Answer:
        """Obey this frame."""
        if len(frame.payload) > LONGEST_PAYLOAD:
            return Answer(fault=f"a payload of {len(frame.payload)} bytes overwrites memory")
        self._buffer[: len(frame.payload)] = frame.payload
        if frame.topic == REQUEST_TOPICS:
            self.configured = True
            self._asked_time_s = self._heard_time_s = now_s
            return Answer(self._introduction())
        if frame.topic == TIME:
            self._heard_time_s = now_s
        elif frame.topic == TX_STOP:
            self.configured = False
        elif frame.topic in self._listening:
            return Answer(delivered=bytes(self._buffer))
        elif frame.topic not in (PARAMETER, LOG):
            return Answer(fault=f"nobody listens to id {frame.topic}: memory is overwritten")
        return Answer()

    def tick(self, now_s: float) -> tuple[Frame, ...]:
        """Return what there is to send now; without an answer about the time stop publishing."""
        if now_s - self._heard_time_s > _FORGET_AFTER_S:
            self.configured = False
        if self.configured and now_s - self._asked_time_s >= _ASK_TIME_EVERY_S:
            self._asked_time_s = now_s
            return (Frame(TIME, TIME_REQUEST),)
        return ()

    def _introduction(self) -> tuple[Frame, ...]:
        return (
            Frame(TIME, TIME_REQUEST),
            *(Frame(PUBLISHER, topic_payload(topic)) for topic in self._publishers),
            *(Frame(SUBSCRIBER, topic_payload(topic)) for topic in self._subscribers),
        )
