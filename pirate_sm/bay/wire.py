"""Which topics a robot's firmware has, and what its arrays and states look like on the wire."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from pirate_sm.bay.conversation import FIRST_TOPIC, SUBSCRIBERS, Message, Topic
from pirate_sm.bay.messages import Content, MessageType, message_types
from pirate_sm.bay.switches import Topic as TopicName
from pirate_sm.errors import UsageError
from pirate_sm.model.profile import Profile
from pirate_sm.model.wire import Serial, SetpointTopic


class Array(NamedTuple):
    """Setpoints as they came.

    Attributes:
        setpoint_id: The id.
        counts: An integer per slot.
        hold: A bit per slot that the dead man's switch keeps.
    """

    setpoint_id: int
    counts: tuple[int, ...]
    hold: int = 0

    @property
    def tripped(self) -> Array:
        """What the dead man's switch makes of it: what is not held is zero."""
        kept = (count if self.hold >> slot & 1 else 0 for slot, count in enumerate(self.counts))
        return self._replace(counts=tuple(kept))


def serial_of(profile: Profile) -> Serial:
    """What the profile says of its serial link.

    Raises:
        UsageError: Nothing.
    """
    if profile.serial is None:
        raise UsageError(f"robot {profile.robot} has no serial link: its profile lacks `serial`")
    return profile.serial


class Wire:
    """The robot's messages.

    Args:
        profile: The robot.
        texts: Message texts by type name, see :func:`~pirate_sm.bay.messages.message_types`.
        wrong_md5: Topics announced with another md5 than theirs.

    Raises:
        UsageError: Profile and texts do not fit together.
    """

    def __init__(
        self, profile: Profile, texts: Mapping[str, str], wrong_md5: Sequence[TopicName] = ()
    ) -> None:
        self._serial = serial = serial_of(profile)
        slots = profile.slots
        link = profile.link
        self._steps = tuple(
            link.angle_resolution if slot.unit == "angle" else link.duty_resolution
            for slot in slots
        )
        # What a sketch has compiled in whose messages have no field for it.
        zero = set(profile.safe_state.zero)
        self._kept = sum(1 << at for at, slot in enumerate(slots) if slot.name not in zero)
        types = message_types(texts)
        self._setpoints, self._echo, self._state = (
            _type(types, each.type) for each in (serial.setpoints, serial.echo, serial.state)
        )
        for kind, topic in ((self._setpoints, serial.setpoints), (self._echo, serial.echo)):
            _check_array(kind, topic, len(slots))
        self._id_bits = self._setpoints.bits(serial.setpoints.id) - len(slots)
        self._check_state(max((len(board.channels) for board in profile.boards), default=0))

        def announced(number: int, name: TopicName, topic: str, kind: MessageType) -> Topic:
            md5 = kind.md5[::-1] if name in wrong_md5 else kind.md5
            return Topic(number, topic, kind.name, md5)

        first = FIRST_TOPIC + SUBSCRIBERS
        self.publishers = (
            announced(first, "state", serial.state.topic, self._state),
            announced(first + 1, "echo", serial.echo.topic, self._echo),
        )
        self.subscribers = (
            announced(FIRST_TOPIC, "setpoints", serial.setpoints.topic, self._setpoints),
        )

    @property
    def one_value(self) -> bool:
        """Whether a state message is one value instead of a board."""
        return self._serial.state.layout == "value"

    def _check_state(self, most: int) -> None:
        state = self._serial.state
        self._state.room(state.board)
        if self.one_value:
            self._state.room(state.channel)
            self._state.room(state.value)
            return
        room = self._state.room(state.values)
        if room is not None and room < most:
            raise UsageError(
                f"field '{state.values}' of message {self._state.name} has room for {room}"
                f" numbers, and a board has {most} channels"
            )

    def state(self, board: int, channel: int, counts: Sequence[float]) -> Message:
        """What a board has measured; the channel counts only where one value is a message."""
        state = self._serial.state
        content: dict[str, float | Sequence[float]] = {state.board: board}
        if self.one_value:
            content |= {state.channel: channel, state.value: counts[0]}
        else:
            content[state.values] = counts
        return Message(self.publishers[0].id, self._state.pack(content))

    def echo(self, array: Array) -> Message:
        """The array, said back."""
        echo = self._serial.echo
        number, more = array.setpoint_id, {}
        if echo.hold == echo.id:
            number |= array.hold << self._id_bits
        elif echo.hold:
            more[echo.hold] = array.hold
        content: Content = {echo.id: number, echo.values: array.counts, **more}
        return Message(self.publishers[1].id, self._echo.pack(content))

    def array(self, payload: bytes) -> Array | None:
        """The array that a receive buffer begins with; None where it holds none."""
        setpoints = self._serial.setpoints
        hold = setpoints.hold
        found = self._setpoints.unpack(
            payload, (setpoints.id, setpoints.values, hold or setpoints.id)
        )
        if found is None or len(found[1]) != len(self._steps):
            return None
        (number,), counts, (mask,) = found
        if hold == setpoints.id:
            return Array(number & (1 << self._id_bits) - 1, counts, number >> self._id_bits)
        return Array(number, counts, mask if hold else self._kept)

    def values(self, array: Array) -> tuple[float, ...]:
        """The array as duty cycles and angles in rad."""
        pairs = zip(array.counts, self._steps, strict=True)
        return tuple(count * step for count, step in pairs)


def _type(types: Mapping[str, MessageType], name: str) -> MessageType:
    if name not in types:
        raise UsageError(f"there is no message text of {name}")
    return types[name]


def _check_array(kind: MessageType, topic: SetpointTopic, slots: int) -> None:
    kind.room(topic.id)
    if topic.hold:
        kind.room(topic.hold)
    room = kind.room(topic.values)
    if room is not None and room != slots:
        raise UsageError(
            f"field '{topic.values}' of message {kind.name} has room for {room} numbers,"
            f" and the robot has {slots} slots"
        )
