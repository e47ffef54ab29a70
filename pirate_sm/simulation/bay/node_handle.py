"""The device's side of the rosserial protocol, as the Arduino client's node handle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from pirate_sm.robot.rosserial.frames import LONGEST_PAYLOAD, SerialFrame
from pirate_sm.robot.rosserial.topics import (
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
"""Subscribers' ids begin at ``FIRST_OF_THE_DEVICE``, publishers' ids this many later."""

_ASK_TIME_EVERY_S = 2.5
_FORGET_AFTER_S = 11.0


class NodeReply(NamedTuple):
    """The device's reaction to a frame.

    Attributes:
        says: Frames to send, in order.
        delivered: For a subscriber: the receive buffer, which begins with the payload. Behind a
            short payload it holds remains of earlier ones.
        fault: What the host did wrong; empty if nothing.
    """

    says: tuple[SerialFrame, ...] = ()
    delivered: bytes | None = None
    fault: str = ""


class NodeHandle:
    """Answers the host; sends nothing until the host asks for its topics.

    Args:
        publishers: Topics that the device sends, in the order of their introduction.
        subscribers: Topics that it receives.

    Attributes:
        configured: Whether the host has asked for its topics and answers its time requests; if not,
            it publishes nothing.
    """

    def __init__(self, publishers: Sequence[TopicInfo], subscribers: Sequence[TopicInfo]) -> None:
        self.configured = False
        self._publishers = tuple(publishers)
        self._subscribers = tuple(subscribers)
        self._listening = frozenset(topic.number for topic in subscribers)
        self._buffer = bytearray(LONGEST_PAYLOAD)
        self._asked_time_s = -math.inf
        self._heard_time_s = -math.inf

    def take(self, frame: SerialFrame, now_s: float) -> NodeReply:
        """Handle this frame and return the reaction."""
        if len(frame.payload) > LONGEST_PAYLOAD:
            return NodeReply(fault=f"a payload of {len(frame.payload)} bytes overwrites memory")
        self._buffer[: len(frame.payload)] = frame.payload
        if frame.topic == REQUEST_TOPICS:
            self.configured = True
            self._asked_time_s = self._heard_time_s = now_s
            return NodeReply(self._introduction())
        if frame.topic == TIME:
            self._heard_time_s = now_s
        elif frame.topic == TX_STOP:
            self.configured = False
        elif frame.topic in self._listening:
            return NodeReply(delivered=bytes(self._buffer))
        elif frame.topic not in (PARAMETER, LOG):
            return NodeReply(fault=f"nobody listens to id {frame.topic}: memory is overwritten")
        return NodeReply()

    def tick(self, now_s: float) -> tuple[SerialFrame, ...]:
        """Return the frames to send now; without answers to time requests stop publishing."""
        if now_s - self._heard_time_s > _FORGET_AFTER_S:
            self.configured = False
        if self.configured and now_s - self._asked_time_s >= _ASK_TIME_EVERY_S:
            self._asked_time_s = now_s
            return (SerialFrame(TIME, TIME_REQUEST),)
        return ()

    def _introduction(self) -> tuple[SerialFrame, ...]:
        return (
            SerialFrame(TIME, TIME_REQUEST),
            *(SerialFrame(PUBLISHER, topic_payload(topic)) for topic in self._publishers),
            *(SerialFrame(SUBSCRIBER, topic_payload(topic)) for topic in self._subscribers),
        )
