"""The syntax of an expression before names and units are resolved; each part has its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from pirate_sm.core.units import Quantity


@dataclass(frozen=True, slots=True)
class SyntaxPart:
    """Any part of an expression, with the place of its first or its governing token."""

    offset: int
    length: int


@dataclass(frozen=True, slots=True)
class NumberPart(SyntaxPart):
    """A number with or without a unit, as written and in SI."""

    text: str
    quantity: Quantity


@dataclass(frozen=True, slots=True)
class TruthPart(SyntaxPart):
    """The constant `true` or `false`."""

    value: bool


@dataclass(frozen=True, slots=True)
class NamePart(SyntaxPart):
    """A signal, a state machine or a word; the analysis decides which."""

    name: str


@dataclass(frozen=True, slots=True)
class ParameterPart(SyntaxPart):
    """A parameter, `$name`."""

    name: str


@dataclass(frozen=True, slots=True)
class UnaryPart(SyntaxPart):
    """A negation, `-x` or `not x`."""

    operator: str
    operand: AnyPart


@dataclass(frozen=True, slots=True)
class ArithmeticPart(SyntaxPart):
    """A sum, difference, product or quotient."""

    operator: str
    left: AnyPart
    right: AnyPart


@dataclass(frozen=True, slots=True)
class ComparisonPart(SyntaxPart):
    """A chain `first op second op third …`, which is true if every neighbouring pair is."""

    first: AnyPart
    rest: tuple[tuple[str, int, AnyPart], ...]  # operator, its offset, what follows


@dataclass(frozen=True, slots=True)
class MembershipPart(SyntaxPart):
    """A membership test, `x in (a, b)` or `x not in (a, b)`."""

    operand: AnyPart
    items: tuple[AnyPart, ...]
    negated: bool


@dataclass(frozen=True, slots=True)
class LogicPart(SyntaxPart):
    """A conjunction or disjunction, `a and b and …` or `a or b or …`."""

    operator: str
    parts: tuple[AnyPart, ...]


@dataclass(frozen=True, slots=True)
class CallPart(SyntaxPart):
    """A function with its arguments."""

    function: str
    arguments: tuple[AnyPart, ...]


OperationPart: TypeAlias = (
    UnaryPart | ArithmeticPart | ComparisonPart | MembershipPart | LogicPart | CallPart
)
AnyPart: TypeAlias = NumberPart | TruthPart | NamePart | ParameterPart | OperationPart
