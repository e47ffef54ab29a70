"""Arrays of setpoints, their echoes and state messages, as a robot's ``.msg`` texts define them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Profile, Serial, SetpointTopic, StateTopic
from pirate_sm.core.on_disk import opened
from pirate_sm.robot.rosserial.message_types import INTEGERS, Malformed, MessageType, message_types

# --- states ---------------------------------------------------------------------------------------


class StateReading(NamedTuple):
    """The content of one State message.

    Attributes:
        board: Number of the board.
        channel: Number of the channel; -1 if ``values`` are all channels of the board.
        values: Raw counts.
    """

    board: int
    channel: int
    values: tuple[float, ...]


class StateCodec:
    """Packs and unpacks state messages of one type, in either layout.

    Attributes:
        type: The message type.
        room: How many values one message can hold; 0 for any number.

    Raises:
        UsageError: The type lacks a field.
    """

    def __init__(self, kind: MessageType, topic: StateTopic) -> None:
        self.type = kind
        self._topic = topic
        self._by_board = topic.layout == "board"
        plain = (topic.board,) if self._by_board else (topic.board, topic.channel, topic.value)
        for name in plain:
            if kind.field(name).size is not None:
                raise UsageError(f"{kind.name}.msg: '{name}' must be one number")
        size = kind.field(topic.values).size if self._by_board else 1
        if size is None:
            raise UsageError(f"{kind.name}.msg: '{topic.values}' must be an array of numbers")
        self.room = size

    def pack(self, reading: StateReading) -> bytes:
        """Return the payload with this content."""
        topic, values = self._topic, reading.values
        if self._by_board:
            return self.type.pack({topic.board: reading.board, topic.values: values})
        content = {topic.board: reading.board, topic.channel: reading.channel}
        return self.type.pack({**content, topic.value: values[0]})

    def unpack(self, payload: bytes) -> StateReading:
        """Return the content of this payload.

        Raises:
            Malformed: The payload does not fit the type.
        """
        message, topic = self.type.unpack(payload), self._topic
        board = int(getattr(message, topic.board))
        if self._by_board:
            return StateReading(board, -1, tuple(getattr(message, topic.values).tolist()))
        value = float(getattr(message, topic.value))
        return StateReading(board, int(getattr(message, topic.channel)), (value,))


# --- setpoints ------------------------------------------------------------------------------------


_LEAST_NUMBER_BITS = 8
"""At least this many bits of an id must count writings, since 64 writings are remembered."""


class Array(NamedTuple):
    """An array of setpoints, as integers of the wire.

    Attributes:
        number: Its wire id.
        counts: One integer per slot.
        hold: One bit per slot that the firmware's dead man's switch keeps; None if the message has
            no field for it.
    """

    number: int
    counts: tuple[int, ...]
    hold: int | None = None

    @property
    def tripped(self) -> Array:
        """The array after a trip of the dead man's switch: zero where it is not held."""
        hold = self.hold or 0
        kept = (count if hold >> slot & 1 else 0 for slot, count in enumerate(self.counts))
        return self._replace(counts=tuple(kept))


class SetpointCodec:
    """Packs and unpacks arrays of setpoints, or their echoes, of one message type.

    Args:
        kind: The message type.
        topic: Names of the fields; the type must have no others, because nothing could fill them.
        slots: Number of setpoints.

    Attributes:
        type: The message type.
        least: The smallest integer of a slot; ``most`` is the largest.
        id_bits: How many bits of the id count writings; ``ids`` is how many ids there are.

    Raises:
        UsageError: The type cannot carry the setpoints.
    """

    def __init__(self, kind: MessageType, topic: SetpointTopic, slots: int) -> None:
        self.type = kind
        number, values = kind.field(topic.id), kind.field(topic.values)
        others = sorted(set(kind.fields) - {topic.id, topic.values, topic.hold})
        if others:
            raise UsageError(f"{kind.name}.msg: it is unknown what to put into {', '.join(others)}")
        if number.size is not None or number.kind not in INTEGERS:
            raise UsageError(f"{kind.name}.msg: '{topic.id}' must be one integer")
        if values.kind not in INTEGERS or values.size not in {0, slots}:
            raise UsageError(
                f"{kind.name}.msg: '{topic.values}' must be {slots} integers, one for each slot"
            )
        self._id, self._values, self._hold = topic.id, topic.values, topic.hold
        self._slots = slots
        signed = values.kind.startswith("int")
        self.least = -(1 << values.bits - 1) if signed else 0
        self.most = (1 << values.bits - signed) - 1
        self.id_bits = number_bits(kind, topic, slots)
        self.ids = 1 << self.id_bits

    @property
    def holds(self) -> bool:
        """Whether the message has a mask of the slots that the firmware's switch keeps."""
        return bool(self._hold)

    def pack(self, number: int, counts: Sequence[int], hold: int = 0) -> bytes:
        """Return the payload with this id and one integer for each slot.

        Args:
            number: The id.
            counts: One integer per slot.
            hold: One bit per slot to keep; left out if the message has no field for it.
        """
        content: dict[str, float | Sequence[float]] = {self._values: counts}
        if self._hold:
            content[self._hold] = hold
        content[self._id] = hold << self.id_bits | number if self._hold == self._id else number
        return self.type.pack(content)

    def unpack(self, payload: bytes, *, whole: bool = True) -> Array:
        """Return the array in this payload; ``whole`` as in :meth:`MessageType.unpack`.

        Raises:
            Malformed: The payload does not fit the type.
        """
        message = self.type.unpack(payload, whole=whole)
        values = getattr(message, self._values)
        if len(values) != self._slots:
            raise Malformed(f"{len(values)} values, not {self._slots}")
        number, counts = int(getattr(message, self._id)), tuple(values.tolist())
        if self._hold == self._id:
            return Array(number & self.ids - 1, counts, number >> self.id_bits)
        return Array(number, counts, int(getattr(message, self._hold)) if self._hold else None)


class Messages(NamedTuple):
    """The three kinds of messages that a robot's link carries."""

    setpoints: SetpointCodec
    echo: SetpointCodec
    state: StateCodec


def serial_of(profile: Profile) -> Serial:
    """Return the profile's section on the serial link.

    Raises:
        UsageError: The profile has no such section.
    """
    if profile.serial is None:
        raise UsageError(f"the robot {profile.robot} has no section 'serial' in its profile")
    return profile.serial


def read_messages(folder: Path, serial: Serial, slots: int) -> Messages:
    """Return the link's messages, defined by the ``.msg`` texts in this folder.

    Args:
        folder: Contains ``<Type>.msg`` for each type.
        serial: The serial section of the profile.
        slots: How many setpoints an array has.

    Raises:
        UsageError: A text is missing, does not parse or does not fit.
    """
    return link_messages(message_texts(folder, serial), serial, slots, folder)


def message_texts(folder: Path, serial: Serial) -> dict[str, str]:
    """Return every ``.msg`` text in this folder, by its name, ``package/Type``.

    A file does not name its package, so it counts for each package among the link's types.

    Raises:
        UsageError: A text cannot be read.
    """
    packages = {topic.type.partition("/")[0] for topic in _topics(serial)}
    texts: dict[str, str] = {}
    for file in sorted(folder.glob("*.msg")):
        try:
            with opened(file) as stream:
                text = stream.read().decode("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"{file} cannot be read: {error}") from None
        texts |= {f"{package}/{file.stem}": text for package in packages}
    return texts


def link_messages(
    texts: Mapping[str, str], serial: Serial, slots: int, folder: Path = Path()
) -> Messages:
    """Return the link's messages, defined by these texts (see :func:`message_texts`).

    Raises:
        UsageError: A text is missing, does not parse or does not fit.
    """
    setpoints, echo, state = topics = _topics(serial)
    types = message_types([topic.type for topic in topics], texts, folder)
    return Messages(
        SetpointCodec(types[setpoints.type], setpoints, slots),
        SetpointCodec(types[echo.type], echo, slots),
        StateCodec(types[state.type], state),
    )


def number_bits(kind: MessageType, topic: SetpointTopic, slots: int) -> int:
    """Return how many bits of the id count writings; the mask may take the others.

    Raises:
        UsageError: There is no room for the mask.
    """
    number = kind.field(topic.id)
    bits = number.bits - number.kind.startswith("int")
    if not topic.hold:
        return bits
    found = kind.field(topic.hold)
    if found.size is not None or not found.kind.startswith("uint"):
        raise UsageError(f"{kind.name}.msg: '{topic.hold}' must be one unsigned integer")
    spare = _LEAST_NUMBER_BITS if topic.hold == topic.id else 0
    if found.bits < slots + spare:
        raise UsageError(
            f"{kind.name}.msg: '{topic.hold}' has {found.bits} bits, and the mask of {slots} slots "
            f"needs {slots + spare}" + (f", {spare} of them for the id itself" if spare else "")
        )
    return bits - slots if spare else bits


def _topics(serial: Serial) -> tuple[SetpointTopic, SetpointTopic, StateTopic]:
    return serial.setpoints, serial.echo, serial.state
