"""Messages of a robot's ``.msg`` texts: their md5 as announced, and their bytes on the wire."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from copy import copy
from functools import cache
from typing import Any, TypeAlias

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from pirate_sm.errors import UsageError

Content: TypeAlias = Mapping[str, float | Sequence[float]]

_TEXT = "string"


class MessageType:
    """One message type.

    Attributes:
        name: As it stands on the wire, ``package/Type``.
        md5: Of its definition, 32 hex digits.
    """

    def __init__(self, name: str, store: Typestore) -> None:
        self.name = name
        self._store = store
        self._known = _inner(name)
        try:
            self.md5: str = store.generate_msgdef(self._known, ros_version=1)[1]
        except (TypesysError, KeyError) as error:
            raise UsageError(f"the message text of {name} cannot be used: {error}") from None
        self._fields = dict(store.fielddefs[self._known][1])
        self._blank = _blank(store, self._known)

    def room(self, field: str) -> int | None:
        """How many numbers a field holds; None for any number of them.

        Raises:
            UsageError: There is no such field, or it holds no numbers.
        """
        kind, what = self._field(field)
        if kind == Nodetype.BASE:
            return 1
        return what[1] if kind == Nodetype.ARRAY else None

    def bits(self, field: str) -> int:
        """How many bits one number of a field has."""
        kind, what = self._field(field)
        element = what if kind == Nodetype.BASE else what[0][1]
        return np.dtype(str(element[0])).itemsize * 8

    def _field(self, field: str) -> tuple[Nodetype, Any]:
        if field not in self._fields:
            raise UsageError(f"message {self.name} has no field '{field}'")
        kind, what = self._fields[field]
        element = what if kind == Nodetype.BASE else what[0][1]
        if kind == Nodetype.NAME or element[0] == _TEXT:
            raise UsageError(f"field '{field}' of message {self.name} holds no numbers")
        return kind, what

    def pack(self, content: Content) -> bytes:
        """The message's bytes; fields not named, and the rest of longer arrays, are zero.

        Raises:
            UsageError: A field is not there, or has no room for its numbers.
        """
        message = copy(self._blank)
        for field, value in content.items():
            kind, what = self._field(field)
            if kind == Nodetype.BASE:
                assert not isinstance(value, Sequence)
                setattr(message, field, _held([value], np.dtype(what[0]))[0])
                continue
            assert isinstance(value, Sequence)
            size = self.room(field)
            size = len(value) if size is None else size
            if len(value) > size:
                raise UsageError(
                    f"field '{field}' of message {self.name} has room for {size} numbers,"
                    f" not for {len(value)}"
                )
            made = np.zeros(size, dtype=what[0][1][0])
            made[: len(value)] = _held(value, made.dtype)
            setattr(message, field, made)
        return bytes(self._store.serialize_ros1(message, self._known))

    def unpack(self, raw: bytes, fields: Sequence[str]) -> tuple[tuple[int, ...], ...] | None:
        """The integers in these fields; None where the bytes make no such message.

        Args:
            raw: Begins with the message; what follows is not looked at.
            fields: Their names.
        """
        definition = self._store.get_msgdef(self._known)
        try:
            message: Any = definition.deserialize_ros1(raw, 0, definition.cls, self._store)[0]
        except (SerdeError, struct.error, ValueError):
            return None
        found = (np.atleast_1d(getattr(message, field)) for field in fields)
        return tuple(tuple(int(each) for each in numbers) for numbers in found)


def _inner(name: str) -> str:
    package, _, kind = name.partition("/")
    return f"{package}/msg/{kind}"


def _held(values: Sequence[float], dtype: np.dtype[Any]) -> np.ndarray[Any, Any]:
    """The numbers as elements of this type can hold them."""
    if dtype.kind not in "iu":
        return np.array(values, dtype=dtype)
    low, high = _limits(dtype)
    return np.array([min(max(round(value), low), high) for value in values], dtype=dtype)


@cache
def _limits(dtype: np.dtype[Any]) -> tuple[int, int]:
    limits = np.iinfo(dtype)
    return limits.min, limits.max


def _blank(store: Typestore, known: str) -> Any:
    """A message in which everything is zero or empty."""
    content: dict[str, Any] = {}
    for field, (kind, what) in store.fielddefs[known][1]:
        if kind == Nodetype.BASE:
            content[field] = "" if what[0] == _TEXT else np.dtype(str(what[0])).type(0)
        elif kind == Nodetype.NAME:
            content[field] = _blank(store, str(what))
        else:
            content[field] = _blank_array(store, what, kind == Nodetype.ARRAY)
    return store.types[known](**content)


def _blank_array(store: Typestore, what: Any, fixed: bool) -> Any:
    (kind, element), size = what
    count = size if fixed else 0
    if kind == Nodetype.NAME:
        return [_blank(store, str(element)) for _ in range(count)]
    if element[0] == _TEXT:
        return [""] * count
    return np.zeros(count, dtype=element[0])


def message_types(texts: Mapping[str, str]) -> dict[str, MessageType]:
    """The types that these texts define, by name.

    Args:
        texts: The ``.msg`` text of each type, by its name on the wire, ``package/Type``.

    Raises:
        UsageError: A text is none.
    """
    store = get_typestore(Stores.ROS1_NOETIC)
    for name, text in texts.items():
        plain = text.replace("\r\n", "\n").replace("\r", "\n")
        try:
            store.register(get_types_from_msg(plain, _inner(name)))
        except TypesysError as error:
            raise UsageError(f"the message text of {name} cannot be used: {error}") from None
    return {name: MessageType(name, store) for name in texts}
