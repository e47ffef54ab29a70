"""Encodes the engine's values and records as JSON and decodes them, without loss.

Python writes the shortest text that reads as the same float64. NaN is written as ``null`` and the
infinities as ``"inf"`` and ``"-inf"``, because JSON has none of them.

Records are checkpoints, and with what a mission begins or is resumed. Their text is derived field
by field from the types of the engine's own records. A new field needs no change here unless it has
a new type.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import inf, nan
from types import NoneType, UnionType
from typing import (
    Any,
    Literal,
    NamedTuple,
    TypeAlias,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from pirate_sm.core.effects import Unmet
from pirate_sm.core.engine import EngineState
from pirate_sm.core.resuming import Resumption
from pirate_sm.core.robot import Mark, RobotState

# --- values ---------------------------------------------------------------------------------------


JsonSchema: TypeAlias = dict[str, Any]
T = TypeVar("T")


def _as_it_is(value: Any) -> Any:
    return value


@dataclass(frozen=True)
class JsonKind:
    """The JSON encoding of one type.

    Attributes:
        decode: Returns the value of JSON, or raises ``ValueError``.
        encode: Returns the JSON of a value.
        words: Description of the JSON, for readers of the file.
        schema: Its JSON Schema if it is always a number, text or truth value; else None.
    """

    decode: Callable[[Any], Any]
    encode: Callable[[Any], Any] = _as_it_is
    words: str = ""
    schema: JsonSchema | None = None


def number_to_json(value: float) -> float | str | None:
    """Return the number as a JSON value."""
    if value != value:  # noqa: PLR0124 - NaN, faster than a call
        return None
    return value if -inf < value < inf else str(value)


def number_from_json(value: Any) -> float:
    """Return the number in the output of :func:`number_to_json`.

    Raises:
        ValueError: The value is not a number.
    """
    if isinstance(value, float):
        return value
    if value is None:
        return nan
    if value in {"inf", "-inf"}:
        return float(value)
    return whole(value)


def _only(kind: type[T], refusal: str) -> Callable[[Any], T]:
    """Return a function that returns values of this type and raises ``ValueError`` for others."""

    def checked(value: Any) -> T:
        if type(value) is not kind:
            raise ValueError(f"{value!r} is {refusal}")
        return value

    return checked


whole = _only(int, "no number")
truth = _only(bool, "neither true nor false")
text = _only(str, "no text")


_NUMBER = 'number, null where unknown, "inf" or "-inf" where infinite'

NUMBER = JsonKind(number_from_json, number_to_json, _NUMBER)
WHOLE = JsonKind(whole, words="whole number", schema={"type": "integer"})

_PLAIN: dict[Any, JsonKind] = {
    float: NUMBER,
    int: WHOLE,
    bool: JsonKind(truth, words="true or false", schema={"type": "boolean"}),
    str: JsonKind(text, words="text", schema={"type": "string"}),
}

_WORDS: dict[Any, str] = {
    tuple[float, ...]: f"array of numbers, each a {_NUMBER}",
    tuple[str, ...]: "array of texts",
    tuple[tuple[str, float], ...]: f"array of pairs of a name and a {_NUMBER}",
    tuple[tuple[str, str | None], ...]: "array of pairs of a name and a text, null where unknown",
    tuple[Unmet, ...]: f"array of unmet conditions, each an array of {', '.join(Unmet._fields)}",
}
"""Fields of events and effects that are not single values, in words."""


def kind_of(hint: Any) -> JsonKind:
    """Return the encoding of this type of a field of events and effects, described in words.

    Raises:
        KeyError: The type has no encoding.
    """
    if get_origin(hint) is Literal or hint in _PLAIN:
        return _form(hint)
    words = _WORDS[hint]
    form = _row(_listed(Unmet)) if hint == tuple[Unmet, ...] else _form(hint)
    return replace(form, words=words)


def one_of(words: tuple[str, ...]) -> Callable[[Any], str]:
    """Return a function that returns one of these words and raises ``ValueError`` for others."""

    def decode(value: Any) -> str:
        if value not in words:
            raise ValueError(f"{value!r} is none of {', '.join(words)}")
        return text(value)

    return decode


# --- records --------------------------------------------------------------------------------------


def state_to_text(state: EngineState) -> str:
    """Return the state as JSON, without loss."""
    return _to_text(EngineState, state)


def state_from_text(written: str) -> EngineState:
    """Return the state in the output of :func:`state_to_text`.

    Raises:
        ValueError: The text is not a state of this version of the engine.
    """
    state: EngineState = _from_text(EngineState, written)
    return state


def resumption_to_text(resumption: Resumption | None) -> str:
    """Return what a mission resumes with as JSON, without loss; empty for none."""
    return "" if resumption is None else _to_text(Resumption, resumption)


def resumption_from_text(written: str) -> Resumption | None:
    """Return what a mission resumes with, from the output of :func:`resumption_to_text`.

    Raises:
        ValueError: The text is not a resumption by this version of the engine.
    """
    return _from_text(Resumption, written) if written else None


class _AtRest(NamedTuple):
    """What is kept of the robot between two missions; see :class:`RobotState`."""

    configuration: int
    values: tuple[float, ...]
    marks: frozenset[tuple[Literal["region", "part"], int, int]]
    next_id: int
    seeking: frozenset[int]
    sent: bool


def body_to_text(body: RobotState | None) -> str:
    """Return the robot state between two missions as JSON; empty for none."""
    if body is None:
        return ""
    return _to_text(_AtRest, [getattr(body, name) for name in _AtRest._fields])


def body_from_text(written: str) -> RobotState | None:
    """Return the robot state in the output of :func:`body_to_text`.

    Raises:
        ValueError: The text is not a robot state.
    """
    if not written:
        return None
    found: _AtRest = _from_text(_AtRest, written)
    marks = frozenset(Mark(*mark) for mark in found.marks)
    return RobotState(**found._asdict() | {"marks": marks})


def _to_text(kind: Any, value: Any) -> str:
    return json.dumps(_form(kind).encode(value), separators=(",", ":"), allow_nan=False)


def _from_text(kind: Any, written: str) -> Any:
    try:
        return _form(kind).decode(json.loads(written))
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"no {kind.__name__} of this engine: {error!r}") from None


@cache
def _form(hint: Any) -> JsonKind:
    """Return the encoding of values of this type.

    Raises:
        KeyError: The type has no encoding.
    """
    origin, args = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return _optional(*args) if NoneType in args else _one_of_records(args)
    if origin is Literal:
        schema = {"type": "string", "enum": list(args)}
        return JsonKind(one_of(args), words=f"one of {', '.join(args)}", schema=schema)
    if origin is frozenset:
        return _set(_form(args[0]))
    if origin is tuple:
        return _row(_form(args[0])) if args[-1] is Ellipsis else _fixed([*map(_form, args)])
    return _PLAIN[hint] if hint in _PLAIN else _form_of_record(hint)


def _optional(hint: Any, none: Any) -> JsonKind:
    if none is not NoneType or hint is float:  # null is an unknown number
        raise KeyError(hint)
    form = _form(hint)
    return JsonKind(
        lambda value: None if value is None else form.decode(value),
        lambda value: None if value is None else form.encode(value),
    )


def _row(form: JsonKind) -> JsonKind:
    return JsonKind(
        lambda values: tuple([form.decode(value) for value in values]),
        lambda values: [form.encode(value) for value in values],
    )


def _set(form: JsonKind) -> JsonKind:
    return JsonKind(
        lambda values: frozenset([form.decode(value) for value in values]),
        lambda values: [form.encode(value) for value in sorted(values)],
    )


def _fixed(forms: list[JsonKind]) -> JsonKind:
    return JsonKind(
        lambda values: tuple(
            [form.decode(value) for form, value in zip(forms, values, strict=True)]
        ),
        lambda values: [form.encode(value) for form, value in zip(forms, values, strict=True)],
    )


def _listed(kind: Any) -> JsonKind:
    """Return the encoding of a named tuple as an array of its fields."""
    form = _fixed([*map(_form, get_type_hints(kind).values())])
    return replace(form, decode=lambda values: kind(*form.decode(values)))


def _one_of_records(kinds: tuple[type[Any], ...]) -> JsonKind:
    """Return the encoding of one of several records, which differ in their fields."""

    def decode(values: dict[str, Any]) -> Any:
        kind: Any = next((each for each in kinds if values.keys() == {*each._fields}), None)
        if kind is None:
            raise ValueError(f"none of {', '.join(each.__name__ for each in kinds)}")
        return _form(kind).decode(values)

    def encode(value: Any) -> Any:
        kind: Any = type(value)
        return _form(kind).encode(value)

    return JsonKind(decode, encode)


def _form_of_record(kind: Any) -> JsonKind:
    """Return the encoding of a named tuple: an object with exactly its fields."""
    if not issubclass(kind, tuple):
        raise KeyError(kind)
    hints = get_type_hints(kind)
    forms = [(name, _form(hints[name])) for name in kind._fields]

    def decode(values: dict[str, Any]) -> Any:
        later = kind._field_defaults.keys()  # an older engine may lack them
        if not hints.keys() - later <= values.keys() <= hints.keys():
            raise ValueError(f"no {kind.__name__} of this engine")
        known = {name: form.decode(values[name]) for name, form in forms if name in values}
        return kind(**known)

    return JsonKind(
        decode,
        lambda values: {
            name: form.encode(value) for (name, form), value in zip(forms, values, strict=True)
        },
    )
