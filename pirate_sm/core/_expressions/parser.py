"""Parse the text of an expression: tokens, then recursive descent; faults have their places.

The grammar, loosest binding first::

    condition  = conjunction { "or" conjunction }
    conjunction = negation { "and" negation }
    negation   = "not" negation | comparison
    comparison = sum { ("==" | "!=" | "<" | "<=" | ">" | ">=") sum }
               | sum [ "not" ] "in" "(" sum { "," sum } ")"
    sum        = product { ("+" | "-") product }
    product    = sign { ("*" | "/") sign }
    sign       = "-" sign | operand
    operand    = number | "true" | "false" | name | "$" name | "(" condition ")"
               | name "(" condition { "," condition } ")"

A unit belongs to the number before it. In the place of an operand, `in` is a word and not the
operator: `detector == in`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Final, Literal, NamedTuple, NoReturn, TypeAlias

from pirate_sm.core._expressions.vocabulary import FUNCTIONS, KEYWORDS
from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.core.units import UNITS, Quantity, QuantityError, nearest_unit, parse_quantity

# --- faults -----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ExpressionFault:
    """One fault in an expression.

    Attributes:
        message: What is wrong, for users.
        offset: Its position in characters from the start of the expression.
        suggestion: The text to write instead, with the blanks that it needs; empty if unknown.
        length: Number of characters that it covers.
        certain: Whether nothing else than the suggestion can have been meant.
    """

    message: str
    offset: int
    suggestion: str = ""
    length: int = 1
    certain: bool = False


class ExpressionError(UsageError):
    """Raised for an invalid expression; holds all its faults."""

    def __init__(self, faults: Iterable[ExpressionFault]) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: fault.offset))
        first = self.faults[0]
        self.message = first.message
        self.offset = first.offset
        self.suggestion = first.suggestion.strip()
        super().__init__("; ".join(_line(fault) for fault in self.faults))


def refusal(message: str, offset: int, suggestion: str = "", length: int = 1) -> ExpressionError:
    """Return the error for one fault."""
    return ExpressionError([ExpressionFault(message, offset, suggestion, length)])


def _line(fault: ExpressionFault) -> str:
    hint = f", did you mean '{fault.suggestion.strip()}'?" if fault.suggestion else ""
    return f"column {fault.offset + 1}: {fault.message}{hint}"


# --- tokens -----------------------------------------------------------------------------------


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


# --- the syntax, before names and units are resolved ------------------------------------------


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


# --- the grammar ------------------------------------------------------------------------------


DEEPEST_NESTING: Final = 32

_COMPARISONS: Final = frozenset({"==", "!=", "<", "<=", ">", ">="})


def parse(text: str) -> AnyPart:
    """Return the syntax of an expression.

    Raises:
        ExpressionError: The text is not in the grammar, too long or nested too deeply.
    """
    try:
        return _parsed(text)
    except ExpressionError as error:
        [fault] = error.faults
        if not fault.certain:
            raise
    try:
        _parsed(translated(text))
    except ExpressionError:
        fault = replace(fault, certain=False)
    raise ExpressionError([fault])


def _parsed(text: str) -> AnyPart:
    parser = _Parser(tokenize(text))
    part = parser.condition()
    if parser.token.kind != "end":
        parser.refuse("an operator or the end")
    return part


class _Parser:
    def __init__(self, tokens: list[Token]) -> None:
        self._tokens = tokens
        self._position = 0
        self._depth = 0

    @property
    def token(self) -> Token:
        return self._tokens[self._position]

    def _is(self, *texts: str) -> bool:
        return self.token.kind in ("operator", "name") and self.token.text in texts

    def _advance(self) -> Token:
        token = self.token
        self._position += 1
        return token

    def _expect(self, text: str) -> Token:
        if not self._is(text):
            self.refuse(f"'{text}'")
        return self._advance()

    def refuse(self, expected: str) -> NoReturn:
        token = self.token
        if token.kind == "end":
            message = f"the end comes where {expected} is expected"
            raise refusal(message, token.offset)
        meant = token.text.lower()
        suggestion = meant if meant != token.text and meant in ("and", "or", "not", "in") else ""
        message = f"'{token.text}' stands where {expected} is expected"
        raise refusal(message, token.offset, suggestion, len(token.text))

    def _deeper(self) -> None:
        self._depth += 1
        if self._depth > DEEPEST_NESTING:
            message = f"the expression is nested deeper than {DEEPEST_NESTING} levels"
            raise refusal(message, self.token.offset)

    def condition(self) -> AnyPart:
        self._deeper()
        parts, first = [self._conjunction()], self.token
        while self._is("or"):
            self._advance()
            parts.append(self._conjunction())
        self._depth -= 1
        return _joined("or", parts, first)

    def _conjunction(self) -> AnyPart:
        parts, first = [self._negation()], self.token
        while self._is("and"):
            self._advance()
            parts.append(self._negation())
        return _joined("and", parts, first)

    def _negation(self) -> AnyPart:
        if not self._is("not"):
            return self._comparison()
        self._deeper()
        token = self._advance()
        operand = self._negation()
        self._depth -= 1
        return UnaryPart(token.offset, len(token.text), "not", operand)

    def _comparison(self) -> AnyPart:
        first, token = self._sum(), self.token
        if self._is("in", "not"):
            return self._membership(first)
        rest: list[tuple[str, int, AnyPart]] = []
        while self.token.kind == "operator" and self.token.text in _COMPARISONS:
            operator = self._advance()
            rest.append((operator.text, operator.offset, self._sum()))
        if not rest:
            return first
        return ComparisonPart(token.offset, len(token.text), first, tuple(rest))

    def _membership(self, operand: AnyPart) -> AnyPart:
        start = self.token
        negated = self._is("not")
        if negated:
            self._advance()
        self._expect("in")
        self._expect("(")
        items = self._list()
        return MembershipPart(start.offset, len(start.text), operand, items, negated)

    def _list(self) -> tuple[AnyPart, ...]:
        """Return the parts up to the closing parenthesis, which commas separate."""
        items = [self.condition()]
        while self._is(","):
            self._advance()
            items.append(self.condition())
        self._expect(")")
        return tuple(items)

    def _sum(self) -> AnyPart:
        left = self._product()
        while self._is("+", "-"):
            token = self._advance()
            left = ArithmeticPart(token.offset, 1, token.text, left, self._product())
        return left

    def _product(self) -> AnyPart:
        left = self._sign()
        while self._is("*", "/"):
            token = self._advance()
            left = ArithmeticPart(token.offset, 1, token.text, left, self._sign())
        return left

    def _sign(self) -> AnyPart:
        if not self._is("-"):
            return self._operand()
        self._deeper()
        token = self._advance()
        operand = self._sign()
        self._depth -= 1
        return UnaryPart(token.offset, 1, "-", operand)

    def _operand(self) -> AnyPart:
        token = self.token
        if token.quantity is not None:
            self._advance()
            return NumberPart(token.offset, len(token.text), token.text, token.quantity)
        if token.kind == "parameter":
            self._advance()
            return ParameterPart(token.offset, len(token.text), token.text[1:])
        if self._is("("):
            self._advance()
            part = self.condition()
            self._expect(")")
            return part
        if token.kind == "name" and token.text not in ("and", "or", "not"):
            return self._named()
        self.refuse("a value")

    def _named(self) -> AnyPart:
        token = self._advance()
        if token.text in ("true", "false"):
            return TruthPart(token.offset, len(token.text), token.text == "true")
        if not self._is("("):
            return NamePart(token.offset, len(token.text), token.text)
        if token.text not in FUNCTIONS:
            message = f"there is no function '{token.text}', only {one_of(sorted(FUNCTIONS))}"
            suggestion = nearest(token.text, FUNCTIONS) or ""
            raise refusal(message, token.offset, suggestion, len(token.text))
        self._advance()
        return CallPart(token.offset, len(token.text), token.text, self._list())


def _joined(operator: str, parts: list[AnyPart], token: Token) -> AnyPart:
    if len(parts) == 1:
        return parts[0]
    return LogicPart(token.offset, len(token.text), operator, tuple(parts))
