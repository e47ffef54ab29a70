"""Decide whether some conditions can be true and others false at the same time.

Each signal may have any value of its range, or be unknown; the states of the robot are known. A
comparison of two signals or a nonlinear one counts as a free boolean, which makes a *yes* unsure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import NamedTuple, TypeAlias

from pirate_sm.checking.exploring.signal_ranges import (
    ANYTHING,
    Range,
    borders,
    is_linear,
    samples,
    signals,
    span_of,
)
from pirate_sm.core.expressions import BOOLEAN, EnumType, Expression, Vocabulary, tree
from pirate_sm.core.robot import Configuration

# --- answers -------------------------------------------------------------------------------------


Fact: TypeAlias = tuple[tree.Node, bool]
"""A condition, and whether it is true; false means false or unknown."""


class PossibleAnswer(NamedTuple):
    """The answer whether some facts can be true together.

    Attributes:
        sure: False if a *yes* depends on something that is not decided here.
        numbers: Values of signals for which the facts are true; ``words`` likewise.
    """

    possible: bool
    sure: bool = True
    numbers: Mapping[str, float] = {}
    words: Mapping[str, str | None] = {}


def together(answers: Iterable[PossibleAnswer]) -> PossibleAnswer:
    """Return the combined answer to several questions without common signals."""
    numbers: dict[str, float] = {}
    words: dict[str, str | None] = {}
    sure = True
    for answer in answers:
        if not answer.possible:
            return answer
        numbers |= answer.numbers
        words |= answer.words
        sure = sure and answer.sure
    return PossibleAnswer(True, sure, numbers, words)


class StepAnswers(NamedTuple):
    """The answers given during one run of a step.

    Attributes:
        answer: Whether they are possible, how surely, and with which signals.
    """

    facts: tuple[Fact, ...]
    answer: PossibleAnswer


Trigger: TypeAlias = tuple[int, int]
"""Index of a wait and number of one of its triggers."""

NOWHERE = -1
"""Instead of a wait's index: the result does not wait."""


class TooManyQuestionsError(Exception):
    """Raised when a step of the engine evaluates too many conditions to answer together."""


class Related(NamedTuple):
    """The answers about conditions that share signals, directly or indirectly.

    Attributes:
        facts: Numbers of conditions, and whether they are true.
    """

    names: frozenset[str]
    facts: tuple[tuple[int, bool], ...]
    answer: PossibleAnswer


class BranchAnswers(NamedTuple):
    """The values that a branch's condition has had.

    Attributes:
        moved: Whether it depends on a state that differs from the start.
    """

    truth: bool
    moved: bool


# --- possible values of conditions ---------------------------------------------------------------


_Values: TypeAlias = tuple[Mapping[str, tuple[float, ...]], Mapping[str, tuple[str | None, ...]]]
"""Values of numeric signals, and of words."""

MOST_TESTS = 50_000
"""Largest number of evaluations; beyond it an unsure *yes* is assumed."""

MOST_ARGUMENTS = 16
"""Largest number of ``min`` and ``max`` in a comparison that counts as piecewise linear."""

_TRUTHS = ("true", "false", None)


class Conditions:
    """Answers questions about conditions on one robot.

    Args:
        vocabulary: What conditions know.
        spans: The range of each numeric signal.
        regions: Number of words that are states, which are known.

    Attributes:
        vocabulary: What conditions know.
        region_count: Number of words that are states.
        tests: Number of evaluations so far, for limiting the work.
    """

    def __init__(self, vocabulary: Vocabulary, spans: Mapping[str, Range], regions: int) -> None:
        self.vocabulary = vocabulary
        self._spans = spans
        self.region_count = regions
        self._answers: dict[tuple[tuple[Fact, ...], tuple[str | None, ...]], PossibleAnswer] = {}
        self._seen: dict[tree.Node, tuple[frozenset[str], tuple[int, ...]]] = {}
        self._tried: dict[tuple[tree.Node, ...], _Values] = {}
        self.tests = 0

    def within(self, narrower: Mapping[str, Range]) -> Conditions:
        """Return the same for signals of which some have narrower ranges."""
        return Conditions(self.vocabulary, {**self._spans, **narrower}, self.region_count)

    def copied(self) -> Conditions:
        """Return the same with the answers so far, to which each of both adds its own."""
        made = self.within({})
        made._answers, made._seen, made._tried = {**self._answers}, {**self._seen}, {**self._tried}
        made.tests = self.tests
        return made

    def ask(self, facts: Iterable[Fact], states: Sequence[str | None]) -> PossibleAnswer:
        """Return whether all facts can be true together with the regions in these states."""
        answers = (self._ask(group, states) for group in self._groups(dict.fromkeys(facts)))
        return together(answers)

    def anywhere(self, facts: Sequence[Fact], configurations: Iterable[Configuration]) -> bool:
        """Return whether all facts can be true together in one of the configurations."""
        regions = {region for node, _ in facts for region in self.regions(node)}
        asked: set[tuple[str, ...]] = set()
        for states in configurations:
            named = tuple([states[region] for region in regions])
            if named not in asked:  # skip equal questions
                asked.add(named)
                if self.ask(facts, states).possible:
                    return True
            if not regions:
                break
        return False

    def free(self, node: tree.Node) -> frozenset[str]:
        """Return the names on which the condition depends, other than states."""
        return self._look(node)[0]

    def regions(self, node: tree.Node) -> tuple[int, ...]:
        """Return indexes of the regions that the condition depends on."""
        return self._look(node)[1]

    def _look(self, node: tree.Node) -> tuple[frozenset[str], tuple[int, ...]]:
        seen = self._seen.get(node)
        if seen is None:
            signals = [each for each in tree.walk(node) if isinstance(each, tree.Signal)]
            known = self.vocabulary.words[: self.region_count]
            regions = {each.index for each in signals if each.name in known}
            free = frozenset(each.name for each in signals if each.name not in known)
            seen = self._seen[node] = free, tuple(sorted(regions))
        return seen

    def _groups(self, facts: Iterable[Fact]) -> list[tuple[Fact, ...]]:
        """Return the facts in groups that share signals; each group is answered separately."""
        groups: list[tuple[frozenset[str], tuple[Fact, ...]]] = []
        for fact in facts:
            names: frozenset[str] = self.free(fact[0])
            members: tuple[Fact, ...] = (fact,)
            apart = []
            for other_names, others in groups:
                if names & other_names:
                    names, members = names | other_names, (*others, *members)
                else:
                    apart.append((other_names, others))
            groups = [*apart, (names, members)]
        return [members for _, members in groups]

    def _ask(self, facts: tuple[Fact, ...], states: Sequence[str | None]) -> PossibleAnswer:
        self.tests += len(facts)
        relevant = {region for node, _ in facts for region in self.regions(node)}
        known = tuple(
            states[region] if region in relevant else None for region in range(self.region_count)
        )
        key = (facts, known)
        answer = self._answers.get(key)
        if answer is None:
            answer = self._answers[key] = self._ask_group(facts, known)
        return answer

    def _ask_group(self, facts: tuple[Fact, ...], states: tuple[str | None, ...]) -> PossibleAnswer:
        """Return values that satisfy the facts, or whether free booleans satisfy them."""
        facts = tuple([(self._given(node, states), wanted) for node, wanted in facts])
        found, tried = self._witness(facts, states)
        if found.possible:
            return found
        opaque: dict[tree.Node, int] = {}
        size = len(self.vocabulary.words)
        freed = tuple((self._freed(node, opaque, size), wanted) for node, wanted in facts)
        if tried and not opaque:
            return found
        found, _ = self._witness(freed, states, len(opaque))
        return found._replace(sure=False, numbers={}, words={})

    def _given(self, node: tree.Node, states: tuple[str | None, ...]) -> tree.Node:
        """Return the condition without what the states decide, so that less has to be tried."""
        match node:
            case tree.Matches(signal, words) if signal.index < self.region_count:
                state = states[signal.index]
                return node if state is None else tree.TruthValue(state in words)
            case tree.Not(operand):
                given = self._given(operand, states)
                if isinstance(given, tree.TruthValue):
                    return tree.TruthValue(not given.value)
                return tree.Not(given)
            case tree.And(parts) | tree.Or(parts):
                decides = isinstance(node, tree.Or)
                left = [self._given(part, states) for part in parts]
                if tree.TruthValue(decides) in left:
                    return tree.TruthValue(decides)
                left = [part for part in left if not isinstance(part, tree.TruthValue)]
                return type(node)(tuple(left)) if left else tree.TruthValue(not decides)
            case _:
                return node

    def _freed(self, node: tree.Node, opaque: dict[tree.Node, int], first: int) -> tree.Node:
        """Return the condition with each undecided comparison replaced by a free boolean.

        A comparison that the ranges of its signals decide is unknown or has its one truth.
        """
        match node:
            case tree.Compare():
                if _is_decided(node) or not signals(node):
                    return node
                number = opaque.setdefault(node, len(opaque))
                free = tree.Signal(f"?{number}", "word", first + number)
                return tree.Matches(free, _truths(node, self._spans))
            case tree.Known(operand) if not is_linear(operand):  # it may be divided by 0
                number = opaque.setdefault(node, len(opaque))
                return tree.Matches(tree.Signal(f"?{number}", "word", first + number), ("true",))
            case tree.Not(operand):
                return tree.Not(self._freed(operand, opaque, first))
            case tree.And(parts):
                return tree.And(tuple(self._freed(part, opaque, first) for part in parts))
            case tree.Or(parts):
                return tree.Or(tuple(self._freed(part, opaque, first) for part in parts))
            case _:
                return node

    def _witness(
        self, facts: tuple[Fact, ...], states: tuple[str | None, ...], free: int = 0
    ) -> tuple[PossibleAnswer, bool]:
        """Return values that satisfy the facts, and whether all relevant values were tried.

        Args:
            facts: The facts.
            states: The states of the regions.
            free: Number of free booleans after the words.
        """
        numeric, verbal = self._values(tuple([node for node, _ in facts]))
        said = [*verbal.values(), *(_TRUTHS for _ in range(free))]
        combinations = math.prod(len(each) for each in (*numeric.values(), *said))
        if combinations * len(facts) > MOST_TESTS:
            return PossibleAnswer(True, sure=False), False
        self.tests += combinations * len(facts)
        tests = [(_compiled(node), wanted) for node, wanted in facts]
        order, size = self.vocabulary.numbers, len(self.vocabulary.words)
        places = [order.index(name) for name in numeric]
        spots = [self.vocabulary.words.index(name) for name in verbal]
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
                return PossibleAnswer(
                    True, True, numbers, dict(zip(verbal, spoken, strict=False))
                ), True
        return PossibleAnswer(False), True

    def _values(self, nodes: tuple[tree.Node, ...]) -> _Values:
        """Return the values of signals to try, independently of the states."""
        values = self._tried.get(nodes)
        if values is None:
            values = self._tried[nodes] = self._numeric(nodes), self._verbal(nodes)
        return values

    def _numeric(self, nodes: Sequence[tree.Node]) -> dict[str, tuple[float, ...]]:
        """Return the values to try for each signal, including unknown."""
        marks: dict[str, set[float]] = {}
        for node in nodes:
            for each in tree.walk(node):
                names = signals(each) if isinstance(each, tree.Compare | tree.Known) else ()
                for name in names:
                    span = self._spans.get(name, ANYTHING)
                    found: Iterable[float] = (0.0,)
                    if isinstance(each, tree.Compare) and _is_decided(each):
                        found = borders(each, span)
                    marks.setdefault(name, set()).update(found)
        return {
            name: (*samples(found, self._spans.get(name, ANYTHING)), math.nan)
            for name, found in marks.items()
        }

    def _verbal(self, nodes: Sequence[tree.Node]) -> dict[str, tuple[str | None, ...]]:
        """Return the possible values of each word that is not a state."""
        names = dict.fromkeys(
            each.name
            for node in nodes
            for each in tree.walk(node)
            if isinstance(each, tree.Signal)
            and each.kind == "word"
            and self.region_count <= each.index < len(self.vocabulary.words)
        )
        found: dict[str, tuple[str | None, ...]] = {}
        for name in names:
            kind = self.vocabulary.types[name]
            assert isinstance(kind, EnumType)
            found[name] = (*kind.values, None)
        return found


@lru_cache(maxsize=4096)
def _compiled(node: tree.Node) -> Expression:
    return Expression("", BOOLEAN, node)


@lru_cache(maxsize=4096)
def _is_decided(node: tree.Compare) -> bool:
    """Return whether a comparison changes only at borders of a single signal."""
    arguments = sum(len(each.arguments) for each in tree.walk(node) if isinstance(each, tree.Call))
    linear = is_linear(node.left) and is_linear(node.right)
    return len(signals(node)) == 1 and linear and arguments <= MOST_ARGUMENTS


def _truths(node: tree.Compare, spans: Mapping[str, Range]) -> tuple[str, ...]:
    """Return with which values of a free boolean a comparison is true, by its signals' ranges."""
    low, high = span_of(tree.Arithmetic("-", node.left, node.right), spans)
    always, never = {
        "<": (high < 0, low >= 0),
        "<=": (high <= 0, low > 0),
        ">": (low > 0, high <= 0),
        ">=": (low >= 0, high < 0),
    }.get(node.operator, (False, False))
    return ("true", "false") if always else () if never else ("true",)
