"""Can these conditions be true, and those not, at one moment? Signals are free in their ranges.

Each signal may have any value of its range, or be unknown; the states of the robot are known.
What compares two signals, or is not linear, is a free truth of its own: then a *yes* is not sure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import NamedTuple, TypeAlias

from pirate_sm.checking.exploring.pieces import borders, is_linear, samples, signals
from pirate_sm.checking.exploring.ranges import ANYTHING, Range
from pirate_sm.expressions import BOOLEAN, EnumType, Expression, Vocabulary, tree

Fact: TypeAlias = tuple[tree.Node, bool]
"""A condition, and whether it is true; false stands for false and for unknown."""

MOST_COMBINATIONS = 20_000
"""Of values that are tried; beyond, a *yes* is assumed and is not sure."""

_TRUTHS = ("true", "false", None)


class Answer(NamedTuple):
    """Whether it can be so.

    Attributes:
        sure: False where a *yes* rests on something that is not decided here.
        numbers: Signals with which it is so; words likewise.
    """

    possible: bool
    sure: bool = True
    numbers: Mapping[str, float] = {}
    words: Mapping[str, str | None] = {}


class Conditions:
    """Answers questions about conditions on one robot.

    Args:
        vocabulary: What conditions know.
        spans: Range of each numeric signal.
        regions: How many of the words are states, which are known.
    """

    def __init__(self, vocabulary: Vocabulary, spans: Mapping[str, Range], regions: int) -> None:
        self._vocabulary = vocabulary
        self._spans = spans
        self._regions = regions
        self._answers: dict[tuple[tuple[Fact, ...], tuple[str | None, ...]], Answer] = {}

    def ask(self, facts: Iterable[Fact], states: Sequence[str | None]) -> Answer:
        """Whether all facts can hold at once with the regions in these states."""
        key = (tuple(dict.fromkeys(facts)), tuple(states[: self._regions]))
        if key not in self._answers:
            self._answers[key] = self._ask(*key)
        return self._answers[key]

    def _ask(self, facts: tuple[Fact, ...], states: tuple[str | None, ...]) -> Answer:
        numbers: dict[str, float] = {}
        words: dict[str, str | None] = {}
        sure = True
        for group in _groups(facts, self._vocabulary.words[: self._regions]):
            answer = self._ask_group(group, states)
            if not answer.possible:
                return answer
            numbers |= answer.numbers
            words |= answer.words
            sure = sure and answer.sure
        return Answer(True, sure, numbers, words)

    def _ask_group(self, facts: tuple[Fact, ...], states: tuple[str | None, ...]) -> Answer:
        """Values with which it is so; failing that, whether it is so with free truths."""
        found, tried = self._witness(facts, states)
        opaque: dict[tree.Node, int] = {}
        size = len(self._vocabulary.words)
        freed = tuple((_without_opaque(node, opaque, size), wanted) for node, wanted in facts)
        if found.possible or not (opaque or not tried):
            return found
        found, _ = self._witness(freed, states, len(opaque))
        return found._replace(sure=False, numbers={}, words={})

    def _witness(
        self, facts: tuple[Fact, ...], states: tuple[str | None, ...], free: int = 0
    ) -> tuple[Answer, bool]:
        """Values with which the facts hold, and whether all that count have been tried.

        Args:
            facts: The facts.
            states: Of the regions.
            free: How many free truths follow the words.
        """
        nodes = [node for node, _ in facts]
        numeric, verbal = self._numeric(nodes), self._verbal(nodes)
        said = [*verbal.values(), *(_TRUTHS for _ in range(free))]
        if math.prod(len(each) for each in (*numeric.values(), *said)) > MOST_COMBINATIONS:
            return Answer(True, sure=False), False
        tests = [(_compiled(node), wanted) for node, wanted in facts]
        order, size = self._vocabulary.numbers, len(self._vocabulary.words)
        places = [order.index(name) for name in numeric]
        spots = [self._vocabulary.words.index(name) for name in verbal]
        spots += range(size, size + free)
        values = [math.nan] * len(order)
        texts: list[str | None] = [*states, *[None] * (size - len(states) + free)]
        for chosen, spoken in product(product(*numeric.values()), product(*said)):
            for place, value in zip(places, chosen, strict=True):
                values[place] = value
            for spot, word in zip(spots, spoken, strict=True):
                texts[spot] = word
            if all((test.evaluate(values, texts) is True) == wanted for test, wanted in tests):
                numbers = dict(zip(numeric, chosen, strict=True))
                return Answer(True, True, numbers, dict(zip(verbal, spoken, strict=False))), True
        return Answer(False), True

    def _numeric(self, nodes: Sequence[tree.Node]) -> dict[str, tuple[float, ...]]:
        """Per signal the values that are worth trying; unknown is one of them."""
        marks: dict[str, set[float]] = {}
        for node in nodes:
            for each in tree.walk(node):
                names = signals(each) if isinstance(each, tree.Compare | tree.Known) else ()
                for name in names:
                    span = self._spans.get(name, ANYTHING)
                    found = {0.0}
                    if isinstance(each, tree.Compare) and _is_decided(each):
                        found = borders(each, span)
                    marks.setdefault(name, set()).update(found)
        return {
            name: (*samples(found, self._spans.get(name, ANYTHING)), math.nan)
            for name, found in marks.items()
        }

    def _verbal(self, nodes: Sequence[tree.Node]) -> dict[str, tuple[str | None, ...]]:
        """Per word that is not a state's, what it can be."""
        names = dict.fromkeys(
            each.name
            for node in nodes
            for each in tree.walk(node)
            if isinstance(each, tree.Signal)
            and each.kind == "word"
            and self._regions <= each.index < len(self._vocabulary.words)
        )
        found: dict[str, tuple[str | None, ...]] = {}
        for name in names:
            kind = self._vocabulary.types[name]
            assert isinstance(kind, EnumType)
            found[name] = (*kind.values, None)
        return found


@lru_cache(maxsize=4096)
def _compiled(node: tree.Node) -> Expression:
    return Expression("", BOOLEAN, node)


def _free(node: tree.Node, known: Sequence[str]) -> frozenset[str]:
    return frozenset(
        each.name
        for each in tree.walk(node)
        if isinstance(each, tree.Signal) and each.name not in known
    )


def _groups(facts: tuple[Fact, ...], known: Sequence[str]) -> list[tuple[Fact, ...]]:
    """Facts that share signals together: each group can be answered for itself."""
    groups: list[tuple[frozenset[str], tuple[Fact, ...]]] = []
    for fact in facts:
        names: frozenset[str] = _free(fact[0], known)
        members: tuple[Fact, ...] = (fact,)
        apart = []
        for other_names, others in groups:
            if names & other_names:
                names, members = names | other_names, (*others, *members)
            else:
                apart.append((other_names, others))
        groups = [*apart, (names, members)]
    return [members for _, members in groups]


def _is_decided(node: tree.Compare) -> bool:
    """Whether a comparison changes only where its one signal has a border."""
    linear = is_linear(node.left) and is_linear(node.right)
    return len(signals(node)) == 1 and linear


def _without_opaque(node: tree.Node, opaque: dict[tree.Node, int], first: int) -> tree.Node:
    """The condition with each comparison that is not decided here as a free truth."""
    match node:
        case tree.Compare():
            if _is_decided(node) or not signals(node):
                return node
            number = opaque.setdefault(node, len(opaque))
            free = tree.Signal(f"?{number}", "word", first + number)
            return tree.Matches(free, ("true",))
        case tree.Not(operand):
            return tree.Not(_without_opaque(operand, opaque, first))
        case tree.And(parts):
            return tree.And(tuple(_without_opaque(part, opaque, first) for part in parts))
        case tree.Or(parts):
            return tree.Or(tuple(_without_opaque(part, opaque, first) for part in parts))
        case _:
            return node
