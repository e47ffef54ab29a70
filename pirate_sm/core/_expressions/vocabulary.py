"""The names that an expression may use, with their types and the positions of their values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final, Literal, TypeAlias

from pirate_sm.core.units import DIMENSIONLESS, UNITS, Dimension, Quantity, describe

KEYWORDS: Final = frozenset({"and", "or", "not", "in", "true", "false"})
FUNCTIONS: Final = frozenset({"abs", "min", "max", "known", "change"})

_IDENTIFIER: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True)
class NumberType:
    """The type of a number in SI units of a dimension; NaN stands for unknown."""

    dimension: Dimension

    def __str__(self) -> str:
        return describe(self.dimension)


@dataclass(frozen=True, slots=True)
class EnumType:
    """The type of one word out of a closed set; None stands for unknown."""

    values: tuple[str, ...]

    def __str__(self) -> str:
        return "a word"


@dataclass(frozen=True, slots=True)
class BooleanType:
    """The type of a condition; None stands for unknown."""

    def __str__(self) -> str:
        return "a condition"


BOOLEAN: Final = BooleanType()

Type: TypeAlias = NumberType | EnumType | BooleanType

# The value of a mission's parameter: a quantity, a boolean, or a word of some signal.
Constant: TypeAlias = Quantity | bool | str

SlotKind: TypeAlias = Literal["number", "word"]


@dataclass(frozen=True, slots=True)
class SignalSlot:
    """The position of a signal's value: which of the two sequences, and the index."""

    kind: SlotKind
    index: int


class Vocabulary:
    """A closed set of typed names in order, with numbers and words indexed separately.

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

    def dimension(self, name: str) -> Dimension:
        """Return the dimension of a number; of a word none."""
        kind = self.types[name]
        return kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS

    @cached_property
    def said(self) -> frozenset[str]:
        """Return all words that the signals can have."""
        kinds = [kind for kind in self.types.values() if isinstance(kind, EnumType)]
        return frozenset(word for kind in kinds for word in kind.values)

    @cached_property
    def with_changes(self) -> Vocabulary:
        """Return the vocabulary of a wait, which adds the change of each number since it began.

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
        """Return the position of a name's value; KeyError for an unknown name."""
        return self._slots[name]


def change_of(name: str) -> str:
    """Return the name of a signal's change since a wait began, as written in expressions."""
    return f"change({name})"


def _check_name(name: str) -> None:
    """Raise ValueError if an expression cannot use the name, for instance because it is a unit."""
    if not _IDENTIFIER.fullmatch(name):
        raise ValueError(f"'{name}' cannot be used in expressions: letters, digits and _ only")
    for kind, reserved in (("keyword", KEYWORDS), ("function", FUNCTIONS), ("unit", UNITS)):
        if name in reserved:
            raise ValueError(f"'{name}' cannot be the name of a signal: it is a {kind}")


def _check_word(name: str, word: str) -> None:
    """Raise ValueError if an expression cannot use the word; `in` is allowed after `==`."""
    if not _IDENTIFIER.fullmatch(word) or word in KEYWORDS - {"in"}:
        raise ValueError(f"'{word}', a word of '{name}', cannot be used in expressions")
