"""The tree of a checked expression: typed, in SI units, every signal with its slot.

The nodes are frozen and hashable, so that a checker can compare and collect them. Syntactic sugar
is resolved: `a < b < c` is an And, `x != word` is a Not of a Matches, a parameter is its value.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

from pirate_sm.core._expressions.vocabulary import SlotKind

ArithmeticOperator: TypeAlias = Literal["+", "-", "*", "/"]
CompareOperator: TypeAlias = Literal["==", "!=", "<", "<=", ">", ">="]
FunctionName: TypeAlias = Literal["abs", "min", "max"]


@dataclass(frozen=True, slots=True)
class Number:
    """A constant in SI units."""

    value: float


@dataclass(frozen=True, slots=True)
class TruthValue:
    """The constant `true` or `false`."""

    value: bool


@dataclass(frozen=True, slots=True)
class Signal:
    """The value of a signal, found at `index` of the numbers or of the words."""

    name: str
    kind: SlotKind
    index: int


@dataclass(frozen=True, slots=True)
class Negate:
    """A number with the opposite sign."""

    operand: Node


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """A sum, difference, product or quotient; a division by zero is unknown."""

    operator: ArithmeticOperator
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Call:
    """A function of numbers; unknown when any of them is."""

    function: FunctionName
    arguments: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Compare:
    """A comparison of two numbers; unknown when either is."""

    operator: CompareOperator
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Matches:
    """A test whether a signal is one of some words; unknown when the signal is."""

    signal: Signal
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Known:
    """A test whether a value is known; never unknown itself."""

    operand: Node


@dataclass(frozen=True, slots=True)
class Not:
    """A negation: true for false, false for true, unknown for unknown."""

    operand: Node


@dataclass(frozen=True, slots=True)
class And:
    """A conjunction: false when any part is, else unknown when any part is, else true."""

    parts: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Or:
    """A disjunction: true when any part is, else unknown when any part is, else false."""

    parts: tuple[Node, ...]


Node: TypeAlias = (
    Number
    | TruthValue
    | Signal
    | Negate
    | Arithmetic
    | Call
    | Compare
    | Matches
    | Known
    | Not
    | And
    | Or
)


def children(node: Node) -> tuple[Node, ...]:
    """Return the nodes directly below a node."""
    match node:
        case Negate(operand) | Known(operand) | Not(operand):
            return (operand,)
        case Arithmetic(_, left, right) | Compare(_, left, right):
            return (left, right)
        case Call(_, parts) | And(parts) | Or(parts):
            return parts
        case Matches(signal, _):
            return (signal,)
        case _:
            return ()


def walk(node: Node) -> Iterator[Node]:
    """Yield a node and everything below it."""
    yield node
    for child in children(node):
        yield from walk(child)
