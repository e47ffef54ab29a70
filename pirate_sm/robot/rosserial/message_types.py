"""Message types as ``.msg`` texts define them: md5, packing and unpacking (rosbags)."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from copy import copy
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from pirate_sm.core.errors import UsageError, not_installed

try:
    import numpy as np
    from rosbags.interfaces import Nodetype
    from rosbags.serde import SerdeError
    from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
    from rosbags.typesys.store import Typestore
except ModuleNotFoundError as error:
    raise not_installed("the serial link", error.name, "serial") from None

Content: TypeAlias = Mapping[str, float | Sequence[float]]

INTEGERS = {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"}
_NUMBERS = INTEGERS | {"float32", "float64"}
_TEXT = "string"


class Malformed(Exception):  # noqa: N818 - data from outside, at times wrong
    """A payload does not fit its type."""


class Field(NamedTuple):
    """One field of a message.

    Attributes:
        kind: Type of its numbers, such as ``int16``; for other fields, the name of their type.
        size: Number of elements: None for a single number, 0 for any count.
    """

    kind: str
    size: int | None

    @property
    def bits(self) -> int:
        """Bits of one number."""
        return np.dtype(self.kind).itemsize * 8


class MessageType:
    """A message type.

    Args:
        name: Its name, ``package/Type``.
        text: Its definition, for people.
        store: Knows this type and every type that it contains.

    Attributes:
        md5: ROS 1's checksum of the fields, 32 hex digits.
        fields: The fields by name.
    """

    def __init__(self, name: str, text: str, store: Typestore) -> None:
        self.name, self.text = name, text
        self._inner = _inner(name)
        self.md5: str = store.generate_msgdef(self._inner, ros_version=1)[1]
        self.fields = {field: _field(node) for field, node in store.fielddefs[self._inner][1]}
        self._store = store
        self._definition = store.get_msgdef(self._inner)
        self._blank = _blank(store, self._inner)

    @property
    def largest(self) -> int | None:
        """Bytes of the longest payload; None if a field may hold any count of numbers."""
        total = 0
        for kind, size in self.fields.values():
            if kind not in _NUMBERS or size == 0:
                return None
            total += np.dtype(kind).itemsize * (1 if size is None else size)
        return total

    def field(self, name: str) -> Field:
        """Return the field of this name.

        Raises:
            UsageError: There is no such field, or it holds no numbers.
        """
        found = self.fields.get(name)
        if found is None:
            raise UsageError(
                f"{self.name}.msg has no field '{name}', only {', '.join(self.fields)}"
            )
        if found.kind not in _NUMBERS:
            raise UsageError(f"{self.name}.msg: '{name}' holds no numbers")
        return found

    def pack(self, content: Content) -> bytes:
        """Return the payload with these numbers.

        Fields that are not named, and the rest of longer arrays, are zero. A number out of the
        range of an integer type becomes the nearest one in range.

        Raises:
            UsageError: A field does not exist or has no room for its numbers.
        """
        message = copy(self._blank)
        for name, value in content.items():
            setattr(message, name, self._numbers(name, value))
        return bytes(self._store.serialize_ros1(message, self._inner))

    def _numbers(self, name: str, value: float | Sequence[float]) -> Any:
        """Return the content of this field for this value."""
        kind, size = self.field(name)
        dtype = np.dtype(kind)
        if not isinstance(value, Sequence):
            return _held([value], dtype)[0]
        if size and len(value) > size:
            raise UsageError(f"{self.name}.msg: '{name}' holds {size} numbers, not {len(value)}")
        made = np.zeros(size or len(value), dtype=dtype)
        made[: len(value)] = _held(value, dtype)
        return made

    def unpack(self, payload: bytes, *, whole: bool = True) -> Any:
        """Return the message in this payload, with its fields as attributes.

        Args:
            payload: Begins with the message.
            whole: Whether it must end with the message too. A firmware's receive buffer is longer
                than the message.

        Raises:
            Malformed: The payload does not fit the type.
        """
        kind = self._definition
        try:
            message, end = kind.deserialize_ros1(payload, 0, kind.cls, self._store)
        except (SerdeError, struct.error, ValueError) as error:
            raise Malformed(str(error)) from None
        if whole and end != len(payload):
            raise Malformed(f"{len(payload)} bytes, not {end}")
        return message


def message_types(
    names: Iterable[str], texts: Mapping[str, str], folder: Path = Path()
) -> dict[str, MessageType]:
    """Return the message types of these names.

    Args:
        names: Names of the types, ``package/Type``.
        texts: The ``.msg`` text of each type and of the types that it contains, by name.
        folder: The folder of the texts, for error messages.

    Raises:
        UsageError: A text is missing or cannot be used.
    """
    store = get_typestore(Stores.ROS1_NOETIC)
    parsed: dict[str, Any] = {}
    for name, text in texts.items():
        try:
            parsed.update(get_types_from_msg(_plain(text), _inner(name)))
        except TypesysError as error:
            raise _unusable(name, folder, error) from None
    for known in parsed.keys() & store.fielddefs.keys():
        del store.fielddefs[known]
    store.register(parsed)
    return {name: _type(name, texts, store, folder) for name in names}


def _type(name: str, texts: Mapping[str, str], store: Typestore, folder: Path) -> MessageType:
    if name not in texts:
        raise UsageError(
            f"{_file(name, folder)} is missing: put the text of {name} from your firmware there"
        )
    try:
        return MessageType(name, _plain(texts[name]), store)
    except KeyError as error:
        raise _unusable(name, folder, f"nothing defines {error.args[0]}") from None
    except TypesysError as error:
        raise _unusable(name, folder, error) from None


def _unusable(name: str, folder: Path, reason: object) -> UsageError:
    return UsageError(f"{_file(name, folder)}: {' '.join(str(reason).split())}")


def _file(name: str, folder: Path) -> Path:
    return folder / f"{name.partition('/')[2]}.msg"


def _plain(text: str) -> str:
    # rosbags accepts no CRLF, which some editors write.
    return text.replace("\r\n", "\n").replace("\r", "\n").strip()


def _inner(name: str) -> str:
    """Return rosbags' name for a type."""
    package, _, kind = name.partition("/")
    return f"{package}/msg/{kind}"


def _field(node: Any) -> Field:
    """Return the field that a pair of node type and details describes."""
    kind, details = node
    if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return Field(_field(details[0]).kind, int(details[1]))
    return Field(str(details[0]) if kind == Nodetype.BASE else str(details), None)


def _held(values: Sequence[float], dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
    """Return the numbers as elements of this type, clipped to its range."""
    with suppress(OverflowError):
        if dtype.kind not in "iu" or all(isinstance(value, int) for value in values):
            return np.array(values, dtype=dtype)
    low, high = _limits(dtype)
    return np.array([min(max(round(value), low), high) for value in values], dtype=dtype)


@cache
def _limits(dtype: np.dtype[Any]) -> tuple[int, int]:
    limits = np.iinfo(dtype)
    return int(limits.min), int(limits.max)


def _blank(store: Typestore, inner: str) -> Any:
    """Return a message in which every field is zero or empty."""
    content = {field: _blank_value(store, node) for field, node in store.fielddefs[inner][1]}
    return store.types[inner](**content)


def _blank_value(store: Typestore, node: Any) -> Any:
    kind, details = node
    if kind == Nodetype.NAME:
        return _blank(store, str(details))
    if kind == Nodetype.BASE:
        return "" if details[0] == _TEXT else np.dtype(str(details[0])).type(0)
    element, size = details
    count = size if kind == Nodetype.ARRAY else 0
    if element[0] == Nodetype.BASE and element[1][0] != _TEXT:
        return np.zeros(count, dtype=element[1][0])
    return [_blank_value(store, element) for _ in range(count)]
