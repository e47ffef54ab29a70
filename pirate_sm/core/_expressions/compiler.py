"""Compile the tree of an expression: to a Python function, and to code for a small stack machine.

The source of the function is generated from the checked tree only: from floats, slot indexes and
words of the vocabulary, never from the text of the expression. It is evaluated without builtins.
Each node becomes an expression whose value is NaN (numbers) or None (words, conditions) for
unknown. An evaluation takes a fraction of a microsecond; a tree walk would take tens.

The stack machine (:mod:`machine`) runs inside compiled code, so that no condition needs to be
compiled to machine code. Words do not change while it runs, so tests of words are decided here, and
with them the parts of a condition that follow from them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from math import isnan, nan
from types import MappingProxyType
from typing import Any, Final, TypeAlias

from pirate_sm.core._expressions import machine as op
from pirate_sm.core._expressions import tree
from pirate_sm.core._expressions.analysis import analyse
from pirate_sm.core._expressions.parser import parse, refusal
from pirate_sm.core._expressions.vocabulary import BooleanType, Constant, NumberType, Vocabulary

# --- to a Python function ---------------------------------------------------------------------


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


# --- to code for a stack machine --------------------------------------------------------------


Code: TypeAlias = tuple[tuple[int, float], ...]
"""Instructions, each with its argument, in the order in which they are executed."""


_ARITHMETIC: Final = {"+": op.ADD, "-": op.SUBTRACT, "*": op.MULTIPLY, "/": op.DIVIDE}


_COMPARISONS: Final = {
    **{"==": op.EQUAL, "!=": op.DIFFERENT, "<": op.LESS},
    **{"<=": op.AT_MOST, ">": op.GREATER, ">=": op.AT_LEAST},
}


_FUNCTIONS: Final = {"abs": op.ABSOLUTE, "min": op.LEAST, "max": op.GREATEST}


TRUE: Final[Code] = ((op.CONSTANT, 1.0),)


FALSE: Final[Code] = ((op.CONSTANT, 0.0),)


_UNKNOWN: Final[Code] = ((op.CONSTANT, nan),)


Words: TypeAlias = Sequence[str | None]


def code_of(node: tree.Node, words: Words = ()) -> Code:
    """Return the code of a condition or of a number.

    Args:
        node: The checked tree.
        words: What the signals with words are, None for unknown.
    """
    match node:
        case tree.Number(value):
            return ((op.CONSTANT, value),)
        case tree.TruthValue(value):
            return TRUE if value else FALSE
        case tree.Signal(_, kind, index):
            assert kind == "number", "a word is compared, and that is decided here"
            return ((op.NUMBER, index),)
        case tree.Negate(operand):
            return (*code_of(operand, words), (op.NEGATE, 0))
        case tree.Arithmetic(operator, left, right):
            return (*code_of(left, words), *code_of(right, words), (_ARITHMETIC[operator], 0))
        case tree.Call(function, arguments):
            codes = [code_of(each, words) for each in arguments]
            return (*(it for code in codes for it in code), (_FUNCTIONS[function], len(codes)))
        case tree.Compare(operator, left, right):
            return (*code_of(left, words), *code_of(right, words), (_COMPARISONS[operator], 0))
        case _:
            return _logic(node, words)


def _logic(node: tree.Node, words: Words) -> Code:
    match node:
        case tree.Matches(signal, accepted):
            word = words[signal.index]
            if word is None:
                return _UNKNOWN
            return TRUE if word in accepted else FALSE
        case tree.Known(tree.Signal(_, "word", index)):
            return FALSE if words[index] is None else TRUE
        case tree.Known(operand):
            return (*code_of(operand, words), (op.KNOWN, 0))
        case tree.Not(operand):
            return (*code_of(operand, words), (op.NOT, 0))
        case tree.And(parts):
            return _joined([code_of(each, words) for each in parts], FALSE, TRUE, op.ALL)
        case tree.Or(parts):
            return _joined([code_of(each, words) for each in parts], TRUE, FALSE, op.ANY)
        case _:
            raise AssertionError(f"{node} is not a condition")


def _joined(codes: list[Code], deciding: Code, neutral: Code, operation: int) -> Code:
    """Return the code of several conditions, of which one ``deciding`` settles the matter."""
    if deciding in codes:
        return deciding
    left = [code for code in codes if code != neutral]
    if len(left) < 2:
        return left[0] if left else neutral
    return (*(it for code in left for it in code), (operation, len(left)))


def words_in(node: tree.Node) -> tuple[int, ...]:
    """Return the indexes of the words that a condition tests."""
    signals = [each for each in tree.walk(node) if isinstance(each, tree.Signal)]
    return tuple(sorted({each.index for each in signals if each.kind == "word"}))


def never_true(code: Code) -> bool:
    """Return whether a condition is false or unknown, whatever the numbers are."""
    return len(code) == 1 and code[0][0] == op.CONSTANT and (isnan(code[0][1]) or code[0][1] == 0.0)


@lru_cache(maxsize=4096)
def depth_of(code: Code) -> int:
    """Return how many values the machine remembers at most while it runs the code."""
    depth = deepest = 0
    for operation, argument in code:
        if operation in (op.CONSTANT, op.NUMBER):
            depth += 1
        elif operation >= op.LEAST:
            depth += 1 - int(argument)
        elif operation >= op.ADD:
            depth -= 1
        deepest = max(deepest, depth)
    return deepest
