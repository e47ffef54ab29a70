"""Guards of charts as conditions of SCXML, and back.

A guard is written in the part of ECMAScript that python-statemachine reads too: ``In('…')``,
``&&``, ``||``, and ``== false`` instead of ``!``. What is read may use ``!`` as well, and the
``and``, ``or`` and ``not`` of Python.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from typing import Final

DEEPEST_NESTING: Final = 50
"""Deepest nesting of a condition that is read [decided]."""

_TOKEN: Final = re.compile(r"""'[^'\\]*'|"[^"\\]*"|\w+|&&|\|\||[!=]==?|\S""")
_SAME = {"&&": "and", "||": "or", "===": "==", "!==": "!="}
_SAME |= {"true": "True", "false": "False"}


def condition_of(guard: ast.expr) -> str:
    """Return a guard of a chart as a condition of SCXML."""
    match guard:
        case ast.BoolOp(op=operator, values=parts):
            sign = " && " if isinstance(operator, ast.And) else " || "
            return sign.join(map(_part, parts))
        case ast.UnaryOp(operand=operand):
            return f"{_part(operand)} == false"
        case ast.Call(args=[ast.Constant(value=str(state))]):
            return f"In('{state}')"
        case _:
            raise AssertionError(f"the chart was checked: {ast.unparse(guard)}")


def _part(guard: ast.expr) -> str:
    text = condition_of(guard)
    return text if isinstance(guard, ast.Call) else f"({text})"


class ConditionError(Exception):
    """Raised for a condition that cannot be a guard."""


def guard_of(condition: str, state_of: Callable[[str], str]) -> str:
    """Return a condition of SCXML as a guard of a chart.

    Args:
        condition: The condition.
        state_of: Returns the name in the chart of the state with an id.

    Raises:
        ConditionError: It uses something else than states with and, or, not.
    """
    return ast.unparse(_Parser(condition, state_of).whole())


class _Parser:
    """Reads a condition by recursive descent; Python's ``not`` binds less than ``==``, ``!`` more.

    Args:
        condition: The condition.
        state_of: Returns the name in the chart of the state with an id.
    """

    def __init__(self, condition: str, state_of: Callable[[str], str]) -> None:
        self._tokens = [_SAME.get(each, each) for each in _TOKEN.findall(condition)]
        self._tokens.reverse()  # the next one is the last
        self._state_of = state_of
        self._depth = 0

    def whole(self) -> ast.expr:
        found = self._any()
        if self._tokens:
            raise ConditionError(f"'{self._tokens[-1]}' was not expected here")
        return found

    def _any(self) -> ast.expr:
        self._depth += 1
        if self._depth > DEEPEST_NESTING:
            raise ConditionError(f"this is nested more than {DEEPEST_NESTING} deep")
        found = self._joined("or", ast.Or(), lambda: self._joined("and", ast.And(), self._negated))
        self._depth -= 1
        return found

    def _joined(self, word: str, operator: ast.boolop, part: Callable[[], ast.expr]) -> ast.expr:
        parts = [part()]
        while self._takes(word):
            parts.append(part())
        return ast.BoolOp(operator, parts) if len(parts) > 1 else parts[0]

    def _negated(self) -> ast.expr:
        negations = 0
        while self._takes("not"):
            negations += 1
        found = self._compared()
        return ast.UnaryOp(ast.Not(), found) if negations % 2 else found

    def _compared(self) -> ast.expr:
        negative = False
        while self._takes("!"):
            negative = not negative
        found = self._single()
        while self._tokens and self._tokens[-1] in {"==", "!="}:
            unequal = self._tokens.pop() == "!="
            if self._takes("True"):
                negative ^= unequal
            elif self._takes("False"):
                negative ^= not unequal
            else:
                raise ConditionError("only true and false can be compared with here")
        return ast.UnaryOp(ast.Not(), found) if negative else found

    def _single(self) -> ast.expr:
        if self._takes("("):
            found = self._any()
            self._needs(")")
            return found
        if not self._takes("In"):
            what = f"'{self._tokens[-1]}'" if self._tokens else "the end"
            raise ConditionError(f"In('…') was expected instead of {what}")
        self._needs("(")
        name = self._tokens.pop() if self._tokens else ""
        if name[:1] not in {"'", '"'} or len(name) < 2:
            raise ConditionError("In needs the id of a state in quotes: In('…')")
        self._needs(")")
        state = ast.Constant(self._state_of(name[1:-1]))
        return ast.Call(ast.Name("In", ast.Load()), [state], [])

    def _takes(self, token: str) -> bool:
        found = bool(self._tokens) and self._tokens[-1] == token
        if found:
            self._tokens.pop()
        return found

    def _needs(self, token: str) -> None:
        if not self._takes(token):
            what = f"'{self._tokens[-1]}'" if self._tokens else "the end"
            raise ConditionError(f"'{token}' was expected instead of {what}")
