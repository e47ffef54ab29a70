"""Compile the tree of a condition to code for a small stack machine.

The machine runs inside compiled code, where no Python function can be called, and no condition
needs to be compiled to machine code. All its values are floats: a condition is 1 (true), 0 (false)
or NaN (unknown), an unknown number is NaN. It gives what
:class:`~pirate_sm.core._expressions.compiler` gives, to the bit.

Words do not change while the machine runs, so tests of words are decided here, and with them the
parts of a condition that follow from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import isnan, nan
from typing import Final, TypeAlias

from pirate_sm.core._expressions import tree

Code: TypeAlias = tuple[tuple[int, float], ...]
"""Instructions, each with its argument, in the order in which they are executed."""

# The instructions: those that push a value (NUMBER: a signal, by its index), that change one, that
# take two, and that take as many as their argument says.
CONSTANT, NUMBER, NEGATE, ABSOLUTE, KNOWN, NOT, ADD, SUBTRACT, MULTIPLY, DIVIDE = range(10)
EQUAL, DIFFERENT, LESS, AT_MOST, GREATER, AT_LEAST, LEAST, GREATEST, ALL, ANY = range(10, 20)

DEEPEST: Final = 32
"""How many values the machine can remember."""

_ARITHMETIC: Final = {"+": ADD, "-": SUBTRACT, "*": MULTIPLY, "/": DIVIDE}
_COMPARISONS: Final = {
    **{"==": EQUAL, "!=": DIFFERENT, "<": LESS},
    **{"<=": AT_MOST, ">": GREATER, ">=": AT_LEAST},
}
_FUNCTIONS: Final = {"abs": ABSOLUTE, "min": LEAST, "max": GREATEST}

TRUE: Final[Code] = ((CONSTANT, 1.0),)
FALSE: Final[Code] = ((CONSTANT, 0.0),)
_UNKNOWN: Final[Code] = ((CONSTANT, nan),)

Words: TypeAlias = Sequence[str | None]


def code_of(node: tree.Node, words: Words = ()) -> Code:
    """Return the code of a condition or of a number.

    Args:
        node: The checked tree.
        words: What the signals with words are, None for unknown.
    """
    match node:
        case tree.Number(value):
            return ((CONSTANT, value),)
        case tree.TruthValue(value):
            return TRUE if value else FALSE
        case tree.Signal(_, kind, index):
            assert kind == "number", "a word is compared, and that is decided here"
            return ((NUMBER, index),)
        case tree.Negate(operand):
            return (*code_of(operand, words), (NEGATE, 0))
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
            return (*code_of(operand, words), (KNOWN, 0))
        case tree.Not(operand):
            return (*code_of(operand, words), (NOT, 0))
        case tree.And(parts):
            return _joined([code_of(each, words) for each in parts], FALSE, TRUE, ALL)
        case tree.Or(parts):
            return _joined([code_of(each, words) for each in parts], TRUE, FALSE, ANY)
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
    return len(code) == 1 and code[0][0] == CONSTANT and (isnan(code[0][1]) or code[0][1] == 0.0)


@lru_cache(maxsize=4096)
def depth_of(code: Code) -> int:
    """Return how many values the machine remembers at most while it runs the code."""
    depth = deepest = 0
    for operation, argument in code:
        if operation in (CONSTANT, NUMBER):
            depth += 1
        elif operation >= LEAST:
            depth += 1 - int(argument)
        elif operation >= ADD:
            depth -= 1
        deepest = max(deepest, depth)
    return deepest
