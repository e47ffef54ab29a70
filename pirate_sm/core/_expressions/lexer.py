"""Split text into tokens; a unit belongs to the number before it."""

from __future__ import annotations

import re
from typing import Final, Literal, NamedTuple, NoReturn, TypeAlias

from pirate_sm.core._expressions.faults import ExpressionError, ExpressionFault, refusal
from pirate_sm.core._expressions.vocabulary import KEYWORDS
from pirate_sm.core.units import UNITS, Quantity, QuantityError, nearest_unit, parse_quantity

LONGEST_TEXT: Final = 1000

TokenKind: TypeAlias = Literal["number", "name", "parameter", "operator", "end"]


class Token(NamedTuple):
    """One token with its place; `quantity` is the value of a number."""

    kind: TokenKind
    text: str
    offset: int
    quantity: Quantity | None = None


_BLANKS: Final = re.compile(r"[ \t\r\n]*")
_NUMBER: Final = re.compile(r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_NAME: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_PARAMETER: Final = re.compile(r"\$[A-Za-z_][A-Za-z0-9_]*")
_UNIT: Final = re.compile(r"[ \t]*(%|°|[A-Za-z_µ][A-Za-z0-9_]*)(\^-?[0-9])?")
# Blanks around '/' make it a division by a signal: `speed / 2 s`, but `2 m/s`.
_UNIT_FACTOR: Final = re.compile(r"[*/·]([A-Za-z]+)(?:\^-?[0-9])?(?![A-Za-z0-9_(])")
_OPERATOR: Final = re.compile(r"[=!]==?|[<>]=|=[<>]|<>|&&|\|\||:=|\*\*|//|[-+*/<>(),=!&|≤≥≠−×÷]")
_FOREIGN: Final = {
    "&&": "and", "&": "and", "||": "or", "|": "or", "!": "not", "=": "==", "===": "==",
    "!==": "!=", "<>": "!=", "≠": "!=", "=>": ">=", "≥": ">=", "=<": "<=", "≤": "<=",
    "−": "-", "×": "*", "÷": "/", ":=": "", "**": "", "//": "",
}  # fmt: skip
"""Operators of other languages, with what they mean; empty if there is no such thing here."""


def translated(text: str) -> str:
    """Return a text with the operators of other languages replaced by those that they mean."""
    return _OPERATOR.sub(lambda found: _meant(found) or found[0], text)


def tokenize(text: str) -> list[Token]:
    """Return the tokens of an expression, ended by one of kind `end`.

    Raises:
        ExpressionError: The text contains an invalid character, number or unit.
    """
    if len(text) > LONGEST_TEXT:
        message = f"the expression is longer than {LONGEST_TEXT} characters"
        raise refusal(message, LONGEST_TEXT)
    tokens: list[Token] = []
    position = _skip_blanks(text, 0)
    while position < len(text):
        token = _next_token(text, position)
        tokens.append(token)
        position = _skip_blanks(text, position + len(token.text))
    tokens.append(Token("end", "", len(text.rstrip())))
    return tokens


def _skip_blanks(text: str, position: int) -> int:
    match = _BLANKS.match(text, position)
    return match.end() if match else position


def _next_token(text: str, position: int) -> Token:
    if _NUMBER.match(text, position):
        return _number(text, position)
    if match := _NAME.match(text, position):
        return Token("name", match[0], position)
    if match := _PARAMETER.match(text, position):
        return Token("parameter", match[0], position)
    operator = _OPERATOR.match(text, position)
    if operator and operator[0] not in _FOREIGN:
        return Token("operator", operator[0], position)
    if operator:
        _refuse(operator[0], position, _meant(operator))
    _refuse(text[position], position)


def _refuse(found: str, position: int, suggestion: str = "") -> NoReturn:
    if found in "'\"":
        raise refusal("words stand without quotes here", position)
    if found == "$":
        raise refusal("a '$' needs the name of a parameter after it", position)
    message = f"{found!r} is not part of the language of conditions"
    certain = suggestion != "" and found != "="  # which may lack a "<" or ">"
    raise ExpressionError([ExpressionFault(message, position, suggestion, len(found), certain)])


def _meant(found: re.Match[str]) -> str:
    """Return what an operator means here, a word with blanks between it and its neighbours."""
    meant, text = _FOREIGN.get(found[0], found[0]), found.string
    if not meant.isalpha():
        return meant
    before = text[found.start() - 1 : found.start()].strip(" \t\r\n(")
    after = text[found.end() : found.end() + 1].strip()
    return f"{' ' if before else ''}{meant}{' ' if after else ''}"


def _number(text: str, position: int) -> Token:
    """Return the number that begins at `position` with its unit, in SI."""
    number = _NUMBER.match(text, position)
    assert number is not None
    end = number.end()
    unit = _UNIT.match(text, end)
    if unit is not None and unit[1] not in KEYWORDS:
        if unit[1] not in UNITS:
            message = f"unknown unit '{unit[1]}' after {number[0]}"
            raise refusal(message, unit.start(1), nearest_unit(unit[1]), len(unit[1]))
        end = unit.end()
        while (factor := _UNIT_FACTOR.match(text, end)) and factor[1] in UNITS:
            end = factor.end()
    written = text[position:end]
    try:
        return Token("number", written, position, parse_quantity(written))
    except QuantityError as error:
        raise refusal(error.message, position, error.suggestion, len(written)) from None
