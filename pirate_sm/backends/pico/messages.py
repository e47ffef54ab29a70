"""Payloads become values and values payloads, as the ``.msg`` texts in the robot's folder say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from pirate_sm.errors import UsageError
from pirate_sm.model.wire import Serial, SetpointTopic, StateTopic

try:
    import numpy as np
    from rosbags.interfaces import Nodetype
    from rosbags.serde import SerdeError
    from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
except ModuleNotFoundError as error:
    raise UsageError(
        f"the serial backend needs {error.name}, which is not installed: "
        "pip install 'pirate-sm[serial]'"
    ) from None

_INTEGERS = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"}
_NUMBERS = _INTEGERS | {"float32", "float64"}
_LEAST_NUMBER_BITS = 8
"""This many bits of an id must count writings: 64 of them are remembered."""

_ARRAYS = (Nodetype.ARRAY, Nodetype.SEQUENCE)


class Malformed(Exception):  # noqa: N818 - data from outside, expected to be wrong at times
    """A payload is not what its type says."""


class Field(NamedTuple):
    """One field of a message: the type of its numbers, and how many of them.

    Attributes:
        size: None for a plain number, 0 for any count.
    """

    kind: str
    size: int | None


@dataclass(frozen=True)
class MessageType:
    """A type of messages as one ``.msg`` text defines it.

    Attributes:
        name: As on the wire, ``package/Type``.
        md5: ROS 1's sum over the fields.
        text: What we hold, for people to compare.
        fields: By name.
    """

    name: str
    md5: str
    text: str
    fields: dict[str, Field]
    make: Callable[..., Any]
    write: Callable[[Any], bytes]
    read: Callable[[bytes], Any]

    @property
    def largest(self) -> int | None:
        """Bytes of the longest payload; None where a field may hold any count of numbers."""
        total = 0
        for kind, size in self.fields.values():
            if kind not in _NUMBERS or size == 0:
                return None
            total += np.dtype(kind).itemsize * (1 if size is None else size)
        return total


class Array(NamedTuple):
    """One array of setpoints as the wire carries it.

    Attributes:
        number: Its id.
        counts: One integer per slot.
        hold: One bit per slot that the firmware's dead man's switch keeps; None where the message
            has no field for it.
    """

    number: int
    counts: tuple[int, ...]
    hold: int | None = None


class SetpointCodec:
    """Arrays of setpoints, or their echoes, of one message type.

    Args:
        kind: Their type.
        topic: The fields that matter; there must be no others, nobody could fill them.
        slots: How many setpoints there are.

    Raises:
        UsageError: The type cannot carry them.
    """

    def __init__(self, kind: MessageType, topic: SetpointTopic, slots: int) -> None:
        self.type = kind
        number, values = (_field(kind, name) for name in (topic.id, topic.values))
        others = sorted(set(kind.fields) - {topic.id, topic.values, topic.hold})
        if others:
            raise UsageError(f"{kind.name}.msg: nobody knows what to put into {', '.join(others)}")
        if number.size is not None or number.kind not in _INTEGERS:
            raise UsageError(f"{kind.name}.msg: '{topic.id}' must be one integer")
        if values.kind not in _INTEGERS or values.size not in {0, slots}:
            raise UsageError(
                f"{kind.name}.msg: '{topic.values}' must be {slots} integers, one for each slot"
            )
        self._id, self._values, self._slots = topic.id, topic.values, slots
        self._hold = topic.hold
        self._dtype = np.dtype(values.kind)
        bounds = np.iinfo(self._dtype)
        self.least, self.most = int(bounds.min), int(bounds.max)
        self.id_bits = number_bits(kind, topic, slots)
        self.ids = 1 << self.id_bits

    @property
    def holds(self) -> bool:
        """Whether the message says which slots the firmware's dead man's switch keeps."""
        return bool(self._hold)

    def pack(self, number: int, values: Sequence[int], hold: int = 0) -> bytes:
        """Return the payload with this id and one integer for each slot.

        Args:
            number: The id.
            values: One integer per slot.
            hold: One bit per slot to be kept; left out where the message has no field for it.
        """
        fields = {self._id: number, self._values: np.array(values, dtype=self._dtype)}
        if self._hold == self._id:
            fields[self._id] = hold << self.id_bits | number
        elif self._hold:
            fields[self._hold] = hold
        return self.type.write(self.type.make(**fields))

    def unpack(self, payload: bytes) -> Array:
        """Return the array in this payload.

        Raises:
            Malformed: It holds something else.
        """
        message = self.type.read(payload)
        values = getattr(message, self._values)
        if len(values) != self._slots:
            raise Malformed(f"{len(values)} values, not {self._slots}")
        number, counts = int(getattr(message, self._id)), tuple(values.tolist())
        if self._hold == self._id:
            return Array(number & self.ids - 1, counts, number >> self.id_bits)
        hold = int(getattr(message, self._hold)) if self._hold else None
        return Array(number, counts, hold)


class Reading(NamedTuple):
    """What one State message tells.

    Attributes:
        channel: Of the one value; -1 where ``values`` are all channels of the board.
    """

    board: int
    channel: int
    values: tuple[float, ...]


class StateCodec:
    """State messages of one type, in either layout.

    Raises:
        UsageError: The type does not have the fields.
    """

    def __init__(self, kind: MessageType, topic: StateTopic) -> None:
        self.type = kind
        self._topic = topic
        by_board = topic.layout == "board"
        plain = (topic.board,) if by_board else (topic.board, topic.channel, topic.value)
        for name in plain:
            if _field(kind, name).size is not None:
                raise UsageError(f"{kind.name}.msg: '{name}' must be one number")
        if by_board and _field(kind, topic.values).size is None:
            raise UsageError(f"{kind.name}.msg: '{topic.values}' must be an array of numbers")

    def unpack(self, payload: bytes) -> Reading:
        """What this payload tells.

        Raises:
            Malformed: It holds something else.
        """
        message, topic = self.type.read(payload), self._topic
        board = int(getattr(message, topic.board))
        if topic.layout == "board":
            return Reading(board, -1, tuple(getattr(message, topic.values).tolist()))
        value = float(getattr(message, topic.value))
        return Reading(board, int(getattr(message, topic.channel)), (value,))


class Messages(NamedTuple):
    """The three kinds of messages that a robot's link carries."""

    setpoints: SetpointCodec
    echo: SetpointCodec
    state: StateCodec


def read_messages(folder: Path, serial: Serial, slots: int) -> Messages:
    """The link's messages, defined by the ``.msg`` texts in this folder.

    Args:
        folder: Where ``<Type>.msg`` stands for each type.
        serial: Which types they are.
        slots: How many setpoints an array has.

    Raises:
        UsageError: A text is missing, does not parse or does not fit.
    """
    texts = {file.stem: _text(file) for file in sorted(folder.glob("*.msg"))}

    def define(name: str) -> MessageType:
        return _define(name, texts, folder)

    return Messages(
        SetpointCodec(define(serial.setpoints.type), serial.setpoints, slots),
        SetpointCodec(define(serial.echo.type), serial.echo, slots),
        StateCodec(define(serial.state.type), serial.state),
    )


def _text(file: Path) -> str:
    # rosbags takes no CRLF, which editors of another system write.
    return file.read_text(encoding="utf-8").replace("\r\n", "\n").strip()


def _define(name: str, texts: dict[str, str], folder: Path) -> MessageType:
    package, _, stem = name.partition("/")
    if stem not in texts:
        raise UsageError(
            f"{folder / stem}.msg is missing: put the text of {name} from your firmware there"
        )
    inner = f"{package}/msg/{stem}"
    try:
        store = get_typestore(Stores.ROS1_NOETIC)
        types: dict[str, Any] = {}
        for each, text in texts.items():
            types.update(get_types_from_msg(text, f"{package}/msg/{each}"))
        for each in types.keys() & store.fielddefs.keys():
            del store.fielddefs[each]
        store.register(types)
        md5 = store.generate_msgdef(inner, ros_version=1)[1]
    except TypesysError as error:
        raise UsageError(f"{folder / stem}.msg: {' '.join(str(error).split())}") from None

    def read(payload: bytes) -> Any:
        try:
            return store.deserialize_ros1(payload, inner)
        except (SerdeError, ValueError) as error:
            raise Malformed(str(error)) from None

    def write(message: Any) -> bytes:
        return bytes(store.serialize_ros1(message, inner))

    fields = {field: _kind(node) for field, node in store.fielddefs[inner][1]}
    return MessageType(name, md5, texts[stem], fields, store.types[inner], write, read)


def _kind(node: Any) -> Field:
    """What a field holds; the node is a pair of node type and details."""
    kind, details = node
    if kind == Nodetype.BASE:
        return Field(str(details[0]), None)
    if kind in _ARRAYS and details[0][0] == Nodetype.BASE:
        return Field(str(details[0][1][0]), int(details[1]))
    return Field("", None)


def _field(kind: MessageType, name: str) -> Field:
    found = kind.fields.get(name)
    if found is None:
        known = ", ".join(kind.fields)
        raise UsageError(f"{kind.name}.msg has no field '{name}', only {known}")
    if found.kind not in _NUMBERS:
        raise UsageError(f"{kind.name}.msg: '{name}' holds no numbers")
    return found


def number_bits(kind: MessageType, topic: SetpointTopic, slots: int) -> int:
    """Return how many bits of the id count writings; the mask of held slots may take the others.

    Raises:
        UsageError: There is no room for the mask.
    """
    number = np.iinfo(np.dtype(_field(kind, topic.id).kind))
    bits = int(number.max).bit_length()
    if not topic.hold:
        return bits
    found = _field(kind, topic.hold)
    if found.size is not None or not found.kind.startswith("uint"):
        raise UsageError(f"{kind.name}.msg: '{topic.hold}' must be one unsigned integer")
    room = int(np.iinfo(np.dtype(found.kind)).bits)
    spare = _LEAST_NUMBER_BITS if topic.hold == topic.id else 0
    if room < slots + spare:
        raise UsageError(
            f"{kind.name}.msg: '{topic.hold}' has {room} bits, and the mask of {slots} slots needs "
            f"{slots + spare}" + (f", {spare} of them for the id itself" if spare else "")
        )
    return bits - slots if spare else bits
