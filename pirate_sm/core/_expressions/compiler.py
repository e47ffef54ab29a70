"""Compile the tree of an expression to a Python function.

The source of the function is generated from the checked tree only: from floats, slot indexes and
words of the vocabulary, never from the text of the expression. It is evaluated without builtins.
Each node becomes an expression whose value is NaN (numbers) or None (words, conditions) for
unknown. An evaluation takes a fraction of a microsecond; a tree walk would take tens.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, TypeAlias

from pirate_sm.core._expressions import tree
from pirate_sm.core._expressions.analysis import analyse
from pirate_sm.core._expressions.faults import refusal
from pirate_sm.core._expressions.parser import parse
from pirate_sm.core._expressions.vocabulary import BooleanType, Constant, NumberType, Vocabulary

Evaluator: TypeAlias = Callable[[Sequence[float], Sequence[str | None]], bool | float | None]

_NO_PARAMETERS: Final[Mapping[str, Constant]] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Expression:
    """A compiled expression.

    Attributes:
        text: The source text.
        type: Boolean for a condition, otherwise a number with its dimension.
        tree: The checked tree; hashable, and equal for equal meaning.
        names: The signals it depends on.
        evaluate: Returns the value, None for unknown. Its arguments are the values of the
            vocabulary's numbers (SI, NaN for unknown) and words (None for unknown), in its order.
    """

    text: str
    type: NumberType | BooleanType
    tree: tree.Node
    names: frozenset[str] = field(init=False, compare=False)
    evaluate: Evaluator = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        signals = [node for node in tree.walk(self.tree) if isinstance(node, tree.Signal)]
        object.__setattr__(self, "names", frozenset(signal.name for signal in signals))
        object.__setattr__(self, "evaluate", _compiled(self.tree, self.type))

    def __reduce__(self) -> tuple[Any, ...]:
        """Return the arguments for rebuilding it: generated functions cannot be pickled."""
        return Expression, (self.text, self.type, self.tree)


def compile_expression(
    text: str, vocabulary: Vocabulary, parameters: Mapping[str, Constant] = _NO_PARAMETERS
) -> Expression:
    """Return the compiled form of an expression.

    Args:
        text: The expression.
        vocabulary: The names it may use.
        parameters: The value of each `$name`.

    Raises:
        ExpressionError: The syntax is invalid, or names, types or dimensions do not fit.
    """
    typed = analyse(parse(text), vocabulary, parameters)
    if not isinstance(typed.type, NumberType | BooleanType):
        name = typed.node.name if isinstance(typed.node, tree.Signal) else text
        message = f"'{name}' is a word: compare it, as in '{name} == {typed.type.values[0]}'"
        raise refusal(message, 0, length=len(text))
    return Expression(text, typed.type, typed.node)


def compile_condition(
    text: str, vocabulary: Vocabulary, parameters: Mapping[str, Constant] = _NO_PARAMETERS
) -> Expression:
    """Return the compiled form of an expression that is true, false or unknown.

    Raises:
        ExpressionError: As for `compile_expression`, or it is a number.
    """
    expression = compile_expression(text, vocabulary, parameters)
    if not isinstance(expression.type, BooleanType):
        message = f"a condition is expected, this is {expression.type}: compare it with something"
        raise refusal(message, 0, length=len(text))
    return expression


def _least(*values: float) -> float:
    """Return the smallest value, NaN if any is NaN; `min` would depend on the order."""
    return math.nan if any(map(math.isnan, values)) else min(values)


def _greatest(*values: float) -> float:
    return math.nan if any(map(math.isnan, values)) else max(values)


_GLOBALS: Final = MappingProxyType(
    {"__builtins__": {}, "nan": math.nan, "abs": abs, "min": _least, "max": _greatest}
)


def _compiled(node: tree.Node, kind: NumberType | BooleanType) -> Evaluator:
    source = _Source()
    body = source.of(node)
    if isinstance(kind, NumberType):
        value = source.fresh()
        body = f"None if ({value} := {body}) != {value} else {value}"
    code = compile(f"lambda n, w: {body}", "<expression>", "eval")
    evaluator: Evaluator = eval(code, dict(_GLOBALS))
    return evaluator


class _Source:
    """Writes Python source with temporaries local to the generated function."""

    def __init__(self) -> None:
        self._temporaries = 0

    def fresh(self) -> str:
        self._temporaries += 1
        return f"t{self._temporaries}"

    def of(self, node: tree.Node) -> str:
        match node:
            case tree.Number(value):
                return f"({value!r})" if value < 0.0 else repr(value)
            case tree.TruthValue(value):
                return repr(value)
            case tree.Signal(_, kind, index):
                return f"{'n' if kind == 'number' else 'w'}[{index}]"
            case tree.Negate(operand):
                return f"(-{self.of(operand)})"
            case tree.Arithmetic("/", left, right):
                divisor = self.fresh()
                return f"({self.of(left)} / {divisor} if ({divisor} := {self.of(right)}) else nan)"
            case tree.Arithmetic(operator, left, right):
                return f"({self.of(left)} {operator} {self.of(right)})"
            case tree.Call(function, arguments):
                return f"{function}({', '.join(map(self.of, arguments))})"
            case _:
                return f"({self._condition(node)})"

    def _condition(self, node: tree.Node) -> str:
        match node:
            case tree.Compare(operator, left, right):
                return self._comparison(operator, left, right)
            case tree.Matches(signal, words):
                value = self.fresh()
                test = f"== {words[0]!r}" if len(words) == 1 else f"in {words!r}"
                return f"None if ({value} := {self.of(signal)}) is None else {value} {test}"
            case tree.Known(operand):
                value = self.fresh()
                # NaN differs from itself; a word or a condition is never NaN.
                return f"({value} := {self.of(operand)}) is not None and {value} == {value}"
            case tree.Not(operand):
                value = self.fresh()
                return f"None if ({value} := {self.of(operand)}) is None else not {value}"
            case tree.And(parts):
                values, tests = self._each(parts, "is False")
                return f"False if {' or '.join(tests)} else {' and '.join(values)}"
            case tree.Or(parts):
                values, tests = self._each(parts, "is True")
                unknown = " or ".join(f"{value} is None" for value in values)
                return f"True if {' or '.join(tests)} else None if {unknown} else False"
            case _:
                raise AssertionError(f"{node} is not a condition")

    def _each(self, parts: tuple[tree.Node, ...], test: str) -> tuple[list[str], list[str]]:
        """Return a temporary for each part, and for each a test that also assigns it."""
        values = [self.fresh() for _ in parts]
        tests = [
            f"({value} := {self.of(part)}) {test}"
            for value, part in zip(values, parts, strict=True)
        ]
        return values, tests

    def _comparison(self, operator: str, left: tree.Node, right: tree.Node) -> str:
        sides, tests = [], []
        for node in (left, right):
            if isinstance(node, tree.Number):
                sides.append(self.of(node))
                continue
            value = self.fresh()
            tests.append(f"({value} := {self.of(node)}) != {value}")
            sides.append(value)
        compared = f"{sides[0]} {operator} {sides[1]}"
        return f"None if {' or '.join(tests)} else {compared}" if tests else compared
