"""The names that an expression may use, with their types and where their values are found."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final, Literal, TypeAlias

from pirate_sm.units import UNITS, Dimension, Quantity, describe

KEYWORDS: Final = frozenset({"and", "or", "not", "in", "true", "false"})
FUNCTIONS: Final = frozenset({"abs", "min", "max", "known", "change"})

_IDENTIFIER: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True)
class NumberType:
    """Is the type of a number in SI units of a dimension; NaN stands for unknown."""

    dimension: Dimension

    def __str__(self) -> str:
        return describe(self.dimension)


@dataclass(frozen=True, slots=True)
class EnumType:
    """Is the type of one word out of a closed set; None stands for unknown."""

    values: tuple[str, ...]

    def __str__(self) -> str:
        return "a word"


@dataclass(frozen=True, slots=True)
class BooleanType:
    """Is the type of a condition; None stands for unknown."""

    def __str__(self) -> str:
        return "a condition"


BOOLEAN: Final = BooleanType()

Type: TypeAlias = NumberType | EnumType | BooleanType

# What a parameter of a mission can stand for: a quantity, a truth, or a word of some signal.
Constant: TypeAlias = Quantity | bool | str

SlotKind: TypeAlias = Literal["number", "word"]


@dataclass(frozen=True, slots=True)
class SignalSlot:
    """Says in which of the two value sequences a signal is found, and where."""

    kind: SlotKind
    index: int


class Vocabulary:
    """Is a closed set of typed names; names keep their order, numbers and words counted apart.

    Attributes:
        types: The type of each name.
        numbers: Names of numeric signals in the order of their values.
        words: Names of signals with words in the order of their values.
    """

    def __init__(self, types: Mapping[str, NumberType | EnumType]) -> None:
        for name, kind in types.items():
            _check_name(name)
            for word in kind.values if isinstance(kind, EnumType) else ():
                _check_word(name, word)
        self.types: Mapping[str, NumberType | EnumType] = MappingProxyType(dict(types))
        numeric = {name for name, kind in types.items() if isinstance(kind, NumberType)}
        self.numbers = tuple(name for name in types if name in numeric)
        self.words = tuple(name for name in types if name not in numeric)
        self._slots = {name: SignalSlot("number", index) for index, name in enumerate(self.numbers)}
        self._slots.update(
            {name: SignalSlot("word", index) for index, name in enumerate(self.words)}
        )

    @cached_property
    def said(self) -> frozenset[str]:
        """Return every word that one of the signals can be."""
        kinds = [kind for kind in self.types.values() if isinstance(kind, EnumType)]
        return frozenset(word for kind in kinds for word in kind.values)

    @cached_property
    def with_changes(self) -> Vocabulary:
        """Return the vocabulary of a wait: also how much each number has changed since it began.

        The changes follow the numbers, in the same order.
        """
        extended = Vocabulary(self.types)
        changes = {change_of(name): self.types[name] for name in self.numbers}
        extended.types = MappingProxyType({**self.types, **changes})
        extended.numbers = (*self.numbers, *changes)
        first = len(self.numbers)
        extended._slots |= {name: SignalSlot("number", first + i) for i, name in enumerate(changes)}
        return extended

    def slot(self, name: str) -> SignalSlot:
        """Return where the value of a name is found; KeyError for a name that is not in here."""
        return self._slots[name]


def change_of(name: str) -> str:
    """Return the name of a signal's change since a wait began, as it is written."""
    return f"change({name})"


def _check_name(name: str) -> None:
    """Return when an expression can use the name; a unit after a number would swallow it."""
    if not _IDENTIFIER.fullmatch(name):
        raise ValueError(f"'{name}' cannot be used in expressions: letters, digits and _ only")
    for kind, reserved in (("keyword", KEYWORDS), ("function", FUNCTIONS), ("unit", UNITS)):
        if name in reserved:
            raise ValueError(f"'{name}' cannot be the name of a signal: it is a {kind}")


def _check_word(name: str, word: str) -> None:
    """Return when an expression can use the word; after `==` even `in` can be one."""
    if not _IDENTIFIER.fullmatch(word) or word in KEYWORDS - {"in"}:
        raise ValueError(f"'{word}', a word of '{name}', cannot be used in expressions")
