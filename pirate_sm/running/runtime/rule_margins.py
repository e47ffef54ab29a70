"""How near signals come to the limits of a fault rule."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

from pirate_sm.core.expressions import BOOLEAN, Expression, NumberType, Vocabulary, tree
from pirate_sm.core.robot import FaultSpec
from pirate_sm.core.units import DIMENSIONLESS, Dimension, format_quantity

Numbers = Sequence[float]
Words = Sequence[str | None]


class _Limit(NamedTuple):
    """One comparison of the rule: a value and its limit."""

    what: str
    value: Expression
    limit: Expression
    rises: bool
    dimension: Dimension


class RuleMargin:
    """Follows one way for a rule to hold: comparisons that must all be true, and other conditions.

    Args:
        limits: The comparisons.
        rest: The other conditions; None if there are none.
        held_s: How long the rule must hold, s.
    """

    def __init__(self, limits: tuple[_Limit, ...], rest: Expression | None, held_s: float) -> None:
        self._limits = limits
        self._rest = rest
        self._held_s = held_s
        self._since_s: float | None = None
        self._least: deque[tuple[float, float, Callable[[], str]]] = deque()

    def seen(self, numbers: Numbers, words: Words, now_s: float) -> tuple[float, str]:
        """Return how near the rule has been throughout the time for which it must hold.

        Args:
            numbers: The present signals.
            words: The present words.
            now_s: Time, not earlier than in the last call.

        Returns:
            A share, 1 if the rule holds, and a sentence about the comparison.
        """
        if self._rest is not None and self._rest.evaluate(numbers, words) is not True:
            self._since_s = None
            self._least.clear()
            return 0.0, ""
        if self._since_s is None:
            self._since_s = now_s
        share, sentence = self._now(numbers, words)
        while self._least and self._least[-1][1] >= share:
            self._least.pop()
        self._least.append((now_s, share, sentence))
        while self._least[0][0] < now_s - self._held_s:
            self._least.popleft()
        if now_s - self._since_s < self._held_s:
            return 0.0, ""
        _, least, sentence = self._least[0]
        return least, sentence() if 0 < least < 1 else ""

    def _now(self, numbers: Numbers, words: Words) -> tuple[float, Callable[[], str]]:
        """Return the present share of the comparison that is farthest from its limit."""
        least, sentence = 1.0, str
        for each in self._limits:
            value, limit = each.value.evaluate(numbers, words), each.limit.evaluate(numbers, words)
            share = _share(value, limit, each.rises)
            if share < least:
                least, sentence = share, _Sentence(each, value, limit, self._held_s)  # type: ignore[assignment,arg-type]
        return least, sentence


class _Sentence(NamedTuple):
    """Makes the sentence about a comparison when it is needed."""

    limit: _Limit
    value: float
    bound: float
    held_s: float

    def __call__(self) -> str:
        """Return the sentence."""
        value_text, bound = (_quantity(x, self.limit.dimension) for x in (self.value, self.bound))
        side = "up to" if self.limit.rises else "down to"
        held = f" for {self.held_s:g} s" if self.held_s else ""
        return f"{self.limit.what} came {side} {value_text}{held}, the limit is {bound}"


def margins_of(rule: FaultSpec, vocabulary: Vocabulary) -> list[RuleMargin]:
    """Return each way for the rule to hold that has a limit."""
    ways = rule.when.tree.parts if isinstance(rule.when.tree, tree.Or) else (rule.when.tree,)
    found = []
    for way in ways:
        parts = way.parts if isinstance(way, tree.And) else (way,)
        limits = tuple(_limit(each, vocabulary) for each in parts if isinstance(each, tree.Compare))
        rest = tuple(each for each in parts if not isinstance(each, tree.Compare))
        condition = Expression("", BOOLEAN, tree.And(rest)) if rest else None
        if limits:
            found.append(RuleMargin(limits, condition, rule.held_s))
    return found


def _limit(compare: tree.Compare, vocabulary: Vocabulary) -> _Limit:
    """Return the comparison as a value and its limit; the side with signals is the value."""
    left, right, rises = compare.left, compare.right, compare.operator in (">", ">=")
    if not list(_signals(left)):
        left, right, rises = right, left, not rises
    dimension = _dimension(left, vocabulary)
    kind = NumberType(dimension)
    return _Limit(
        text_of(left), Expression("", kind, left), Expression("", kind, right), rises, dimension
    )


def _share(value: object, limit: object, rises: bool) -> float:
    """Return how near a value is to its limit: 1 beyond it, 0 if either is not positive."""
    if not isinstance(value, float | int) or not isinstance(limit, float | int):
        return 0.0
    small, large = (value, limit) if rises else (limit, value)
    if small >= large:
        return 1.0
    return small / large if small > 0 else 0.0


def _signals(node: tree.Node) -> Iterator[tree.Signal]:
    return (each for each in tree.walk(node) if isinstance(each, tree.Signal))


def _dimension(node: tree.Node, vocabulary: Vocabulary) -> Dimension:
    """Return the dimension of a number's signals; none for products."""
    products = (each for each in tree.walk(node) if isinstance(each, tree.Arithmetic))
    if any(each.operator in "*/" for each in products):
        return DIMENSIONLESS
    kinds = (vocabulary.types[each.name] for each in _signals(node))
    return next((each.dimension for each in kinds if isinstance(each, NumberType)), DIMENSIONLESS)


def text_of(node: tree.Node) -> str:
    """Return a number of a condition as people write it."""
    match node:
        case tree.Signal(name=name):
            return name
        case tree.Number(value=value):
            return f"{value:g}"
        case tree.Negate(operand=operand):
            return f"-{text_of(operand)}"
        case tree.Call(function=function, arguments=arguments):
            return f"{function}({', '.join(map(text_of, arguments))})"
        case tree.Arithmetic(operator=operator, left=left, right=right):
            return f"({text_of(left)} {operator} {text_of(right)})"
        case _:
            return "a condition"


def _quantity(value: float, dimension: Dimension) -> str:
    return format_quantity(float(f"{value:.3g}"), dimension)
