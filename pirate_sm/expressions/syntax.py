"""The syntax of an expression before names and units are resolved; each part has its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from pirate_sm.units import Quantity


@dataclass(frozen=True, slots=True)
class Part:
    """Is any part of an expression, with the place of its first or its governing token."""

    offset: int
    length: int


@dataclass(frozen=True, slots=True)
class NumberPart(Part):
    """Is a number with or without a unit, as written and in SI."""

    text: str
    quantity: Quantity


@dataclass(frozen=True, slots=True)
class TruthPart(Part):
    """Is `true` or `false`."""

    value: bool


@dataclass(frozen=True, slots=True)
class NamePart(Part):
    """Is a signal, a state machine or a word; which of them, the analysis finds out."""

    name: str


@dataclass(frozen=True, slots=True)
class ParameterPart(Part):
    """Is `$name`."""

    name: str


@dataclass(frozen=True, slots=True)
class UnaryPart(Part):
    """Is `-x` or `not x`."""

    operator: str
    operand: AnyPart


@dataclass(frozen=True, slots=True)
class ArithmeticPart(Part):
    """Is a sum, difference, product or quotient."""

    operator: str
    left: AnyPart
    right: AnyPart


@dataclass(frozen=True, slots=True)
class ComparisonPart(Part):
    """Is `first op second op third …`, which holds when every neighbouring pair does."""

    first: AnyPart
    rest: tuple[tuple[str, int, AnyPart], ...]  # operator, its offset, what follows


@dataclass(frozen=True, slots=True)
class MembershipPart(Part):
    """Is `x in (a, b)` or `x not in (a, b)`."""

    operand: AnyPart
    items: tuple[AnyPart, ...]
    negated: bool


@dataclass(frozen=True, slots=True)
class LogicPart(Part):
    """Is `a and b and …` or `a or b or …`."""

    operator: str
    parts: tuple[AnyPart, ...]


@dataclass(frozen=True, slots=True)
class CallPart(Part):
    """Is a function with its arguments."""

    function: str
    arguments: tuple[AnyPart, ...]


OperationPart: TypeAlias = (
    UnaryPart | ArithmeticPart | ComparisonPart | MembershipPart | LogicPart | CallPart
)
AnyPart: TypeAlias = NumberPart | TruthPart | NamePart | ParameterPart | OperationPart
