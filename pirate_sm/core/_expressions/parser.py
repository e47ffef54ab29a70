"""Parse tokens by recursive descent; the grammar, loosest binding first.

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

In the place of an operand, `in` is a word and not the operator: `detector == in`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NoReturn

from pirate_sm.core._expressions.faults import ExpressionError, refusal
from pirate_sm.core._expressions.lexer import Token, tokenize, translated
from pirate_sm.core._expressions.syntax import (
    AnyPart,
    ArithmeticPart,
    CallPart,
    ComparisonPart,
    LogicPart,
    MembershipPart,
    NamePart,
    NumberPart,
    ParameterPart,
    TruthPart,
    UnaryPart,
)
from pirate_sm.core._expressions.vocabulary import FUNCTIONS
from pirate_sm.core.spelling import nearest, one_of

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
