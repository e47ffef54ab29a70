"""The device's side of the rosserial protocol, as the Arduino client's node handle."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from enum import Enum, auto
from pathlib import Path
from typing import NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Profile
from pirate_sm.robot.rosserial import messages
from pirate_sm.robot.rosserial.frames import (
    FIRST_OF_THE_DEVICE,
    LOG,
    LONGEST_PAYLOAD,
    PARAMETER,
    PUBLISHER,
    REQUEST_TOPICS,
    SUBSCRIBER,
    SYNC,
    TIME,
    TIME_REQUEST,
    TX_STOP,
    Direction,
    SerialFrame,
    TopicInfo,
    topic_payload,
)
from pirate_sm.robot.rosserial.message_types import Malformed, MessageType
from pirate_sm.robot.rosserial.messages import Array, StateReading, link_messages, serial_of
from pirate_sm.simulation.bay.bay_defects import Topic as TopicName

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
        self.configured = self._met = False
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
            self.configured = self._met = True
            self._asked_time_s = self._heard_time_s = now_s
            return NodeReply(self._introduction())
        if frame.topic == TIME:
            self._heard_time_s = now_s
        elif frame.topic == TX_STOP:
            self.configured = False
        elif frame.topic in self._listening:
            # A host that has not asked may not know of a restart, and repeats an array.
            return NodeReply(delivered=bytes(self._buffer) if self._met else None)
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


# --- reception of frames -------------------------------------------------------------------------
# Unlike :class:`pirate_sm.robot.rosserial.frames.Decoder` it loses the frame that follows a
# damaged one, as the Arduino client does.


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


# --- topics and messages -------------------------------------------------------------------------


class Wire:
    """The robot's messages.

    Args:
        profile: The robot's profile.
        texts: Message texts by type name, see
            :func:`~pirate_sm.simulation.bay.node_handle.message_texts`.
        wrong_md5: Topics announced with a wrong md5.

    Attributes:
        publishers: Topics that the firmware sends: states, then echoes.
        subscribers: The topic that it receives.
        one_value: Whether a state message holds one value instead of a board's.

    Raises:
        UsageError: Profile and texts do not fit together.
    """

    def __init__(
        self, profile: Profile, texts: Mapping[str, str], wrong_md5: Sequence[TopicName] = ()
    ) -> None:
        serial = serial_of(profile)
        slots, link = profile.slots, profile.link
        self._steps = tuple(
            link.angle_resolution if slot.unit == "angle" else link.duty_resolution
            for slot in slots
        )
        self._own = sum(1 << at for at, slot in enumerate(slots) if slot.unit == "angle")
        # The mask built into a firmware, for messages without one.
        zero = set(profile.safe_state.zero)
        self._kept = sum(1 << at for at, slot in enumerate(slots) if slot.name not in zero)
        self._messages = messages = link_messages(texts, serial, len(slots))
        self.one_value = serial.state.layout == "value"
        self._check_room(max((len(board.channels) for board in profile.boards), default=0))

        def announced(
            number: int, name: TopicName, topic: str, kind: MessageType, way: Direction
        ) -> TopicInfo:
            md5 = kind.md5[::-1] if name in wrong_md5 else kind.md5
            return TopicInfo(number, topic, kind.name, md5, LONGEST_PAYLOAD, way)

        takes, says = FIRST_OF_THE_DEVICE, FIRST_OF_THE_DEVICE + MOST_SUBSCRIBERS
        state, echo, setpoints = messages.state.type, messages.echo.type, messages.setpoints.type
        self.publishers = (
            announced(says, "state", serial.state.topic, state, "publishes"),
            announced(says + 1, "echo", serial.echo.topic, echo, "publishes"),
        )
        self.subscribers = (
            announced(takes, "setpoints", serial.setpoints.topic, setpoints, "takes"),
        )

    def _check_room(self, most: int) -> None:
        state = self._messages.state
        if not self.one_value and 0 < state.room < most:
            raise UsageError(
                f"{state.type.name}.msg has room for {state.room} values, and a board has {most} "
                "channels"
            )

    def state(self, board: int, channel: int, counts: Sequence[float]) -> SerialFrame:
        """Return the frame with the values of a board.

        Args:
            board: Number of the board.
            channel: Number of the channel, if a message holds one value.
            counts: Raw counts of this channel, or of all.
        """
        reading = StateReading(board, channel, tuple(counts))
        return SerialFrame(self.publishers[0].number, self._messages.state.pack(reading))

    def echo(self, array: Array) -> SerialFrame:
        """Return the frame that echoes this array."""
        payload = self._messages.echo.pack(array.number, array.counts, array.hold or 0)
        return SerialFrame(self.publishers[1].number, payload)

    def tripped(self, array: Array) -> Array:
        """Return the array after a trip of the dead man's switch.

        A mask without the slots that have a controller of their own is none: a host sets these.
        """
        hold = array.hold or 0
        held = hold if hold & self._own == self._own else self._kept | self._own
        return array._replace(counts=array._replace(hold=held).tripped.counts)

    def array(self, buffer: bytes) -> Array | None:
        """Return the array at the beginning of a receive buffer; None if there is none."""
        try:
            array = self._messages.setpoints.unpack(buffer, whole=False)
        except Malformed:
            return None
        return array if array.hold is not None else array._replace(hold=self._kept)

    def values(self, array: Array) -> tuple[float, ...]:
        """Return the array as duty cycles and angles in rad."""
        pairs = zip(array.counts, self._steps, strict=True)
        return tuple(count * step for count, step in pairs)


# --- message definitions -------------------------------------------------------------------------


def message_texts(folder: Path, profile: Profile) -> dict[str, str]:
    """Return the ``.msg`` texts of the robot's link, by message name (``package/Type``).

    Args:
        folder: The robot's folder, with its profile.
        profile: The robot's profile.

    Raises:
        UsageError: The robot has no link, or a text cannot be read.
    """
    serial = messages.serial_of(profile)
    return messages.message_texts(folder / serial.messages, serial)
