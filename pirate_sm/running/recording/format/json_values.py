"""Encodes values of the engine's events and effects as JSON and decodes them, without loss.

Python writes the shortest text that reads as the same float64. NaN is written as ``null`` and the
infinities as ``"inf"`` and ``"-inf"``, because JSON has none of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, nan
from typing import Any, Literal, TypeAlias, TypeVar, get_args, get_origin, get_type_hints

from pirate_sm.core.effects import Unmet

JsonSchema: TypeAlias = dict[str, Any]
T = TypeVar("T")


@dataclass(frozen=True)
class JsonKind:
    """The JSON encoding of one type.

    Attributes:
        words: Description of the JSON, for readers of the file.
        schema: Its JSON Schema if it is always a number, text or truth value; else None.
        decode: Returns the value of JSON, or raises ``ValueError``.
        encode: Returns JSON of a value with a NaN or an infinity; None if there can be none.
    """

    words: str
    decode: Callable[[Any], Any]
    encode: Callable[[Any], Any] | None = None
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


def _word(value: Any) -> str | None:
    return None if value is None else text(value)


def _pairs(words: str, decode: Callable[[Any], Any]) -> JsonKind:
    return JsonKind(
        f"array of pairs of a name and a {words}",
        lambda pairs: tuple((text(name), decode(value)) for name, value in pairs),
    )


def _record(kind: type[T], values: list[Any]) -> T:
    """Return the named tuple with these JSON values in the order of its fields."""
    hints = get_type_hints(kind)
    fields = zip(hints.items(), values, strict=True)
    return kind(*[kind_of(hint).decode(value) for (_, hint), value in fields])


_NUMBER = 'number, null where unknown, "inf" or "-inf" where infinite'

NUMBER = JsonKind(_NUMBER, number_from_json, number_to_json)
WHOLE = JsonKind("whole number", whole, schema={"type": "integer"})
TEXT = JsonKind("text", text, schema={"type": "string"})
NUMBERS = JsonKind(
    f"array of numbers, each a {_NUMBER}",
    lambda values: tuple(number_from_json(value) for value in values),
    lambda values: [number_to_json(value) for value in values],
)
_TEXTS = JsonKind("array of texts", lambda values: tuple(text(value) for value in values))
_NUMBERS_BY_NAME = _pairs(_NUMBER, number_from_json)

_KINDS: dict[Any, JsonKind] = {
    float: NUMBER,
    int: WHOLE,
    bool: JsonKind("true or false", truth, schema={"type": "boolean"}),
    str: TEXT,
    tuple[float, ...]: NUMBERS,
    tuple[str, ...]: _TEXTS,
    tuple[tuple[str, float], ...]: JsonKind(
        _NUMBERS_BY_NAME.words,
        _NUMBERS_BY_NAME.decode,
        lambda pairs: [[name, number_to_json(value)] for name, value in pairs],
    ),
    tuple[Unmet, ...]: JsonKind(
        f"array of unmet conditions, each an array of {', '.join(Unmet._fields)}",
        lambda rows: tuple([_record(Unmet, row) for row in rows]),
        lambda rows: [
            [number_to_json(each) if type(each) is float else each for each in row] for row in rows
        ],
    ),
    tuple[tuple[str, str | None], ...]: _pairs("text, null where unknown", _word),
}


def kind_of(hint: Any) -> JsonKind:
    """Return the encoding of this type.

    Raises:
        KeyError: The type has no encoding.
    """
    if get_origin(hint) is Literal:
        words = get_args(hint)
        schema = {"type": "string", "enum": list(words)}
        return JsonKind(f"one of {', '.join(words)}", one_of(words), schema=schema)
    return _KINDS[hint]


def one_of(words: tuple[str, ...]) -> Callable[[Any], str]:
    """Return a function that returns one of these words and raises ``ValueError`` for others."""

    def decode(value: Any) -> str:
        if value not in words:
            raise ValueError(f"{value!r} is none of {', '.join(words)}")
        return text(value)

    return decode
