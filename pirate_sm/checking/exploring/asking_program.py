"""A program whose conditions ask for their values, to try every possible answer once.

The engine runs unchanged. When it evaluates a condition of the mission, the answer comes from a
list of choices. The same step is run again with other choices, until every combination of sensor
values at that moment has been tried. The answers of one moment are always consistent.

A condition that must be held for a time has no effect at the moment in which it becomes true. It is
therefore asked only if the wait continues, and at most one such condition, with those that it
implies, becomes true at a time, because sensors may change again at the next moment. Twelve of them
give thirteen possible cases instead of 4,096.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from pirate_sm.checking.exploring.conditions import (
    NOWHERE,
    BranchAnswers,
    Conditions,
    PossibleAnswer,
    Related,
    StepAnswers,
    TooManyQuestionsError,
    Trigger,
    together,
)
from pirate_sm.core.expressions import Expression, tree
from pirate_sm.core.program import Branch, Program, Wait

T = TypeVar("T")


_NOTHING_ASKED = StepAnswers((), PossibleAnswer(True))

MOST_QUESTIONS = 256
"""Largest number of different conditions in one step."""


class Oracle:
    """Answers the conditions of a program.

    Args:
        conditions: Decides which conditions can be true together.
        start: The robot's initial states.

    Attributes:
        branches: By the place of each branch the values of its condition.
    """

    def __init__(self, conditions: Conditions, start: Sequence[str | None] = ()) -> None:
        self.branches: dict[str, set[BranchAnswers]] = {}
        self._start: Sequence[str | None] = start
        self._conditions = conditions
        self._numbers: dict[tree.Node, int] = {}
        self._nodes: list[tree.Node] = []
        self._names: list[frozenset[str]] = []
        self._known: dict[Hashable, tuple[PossibleAnswer, PossibleAnswer]] = {}
        self._given: dict[int, bool] = {}
        self._related: tuple[Related, ...] = ()
        self._choices: list[bool] = []
        self._taken = 0
        self._due: Collection[Trigger] = ()
        self._held: dict[int, dict[int, None]] = {}  # postponed conditions, by their wait
        self._begun: dict[int, bool] = {}  # answers to postponed conditions
        self._words: Sequence[str | None] = ()

    def program(self, program: Program) -> Program:
        """Return the program with its conditions replaced by questions."""
        instructions = tuple(
            self._asking(index, each) if isinstance(each, Branch | Wait) else each
            for index, each in enumerate(program.instructions)
        )
        return replace(program, instructions=instructions)

    def every(
        self,
        step: Callable[[], T],
        waits: Callable[[T], int] = lambda _: NOWHERE,
        due: Collection[Trigger] = (),
    ) -> Iterator[tuple[T, StepAnswers]]:
        """Yield the result of the step for every possible combination of its conditions.

        Args:
            step: The step, which is run several times.
            waits: Returns the index of the wait of a result, or ``NOWHERE``.
            due: Triggers whose conditions have been held long enough if they are still true.

        Raises:
            TooManyQuestionsError: The step evaluates too many conditions.
        """
        self._due = due
        pending: list[list[bool]] = [[]]
        while pending:
            chosen = pending.pop()
            result = self._run(step, chosen)
            choices = self._choices
            held = tuple(self._held.get(waits(result), ())) if self._held else ()
            if held:
                yield from self._beginnings(step, result, held)
            else:
                yield result, self._moment()
            for place in range(len(choices) - 1, len(chosen) - 1, -1):
                pending.append([*choices[:place], not choices[place]])

    def _run(self, step: Callable[[], T], chosen: list[bool]) -> T:
        self._choices = [*chosen]
        self._given, self._related, self._taken, self._held = {}, (), 0, {}
        return step()

    def _moment(self) -> StepAnswers:
        if not self._given:
            return _NOTHING_ASKED
        facts = tuple((self._nodes[number], truth) for number, truth in self._given.items())
        return StepAnswers(facts, together(each.answer for each in self._related))

    def _beginnings(
        self, step: Callable[[], T], result: T, held: tuple[int, ...]
    ) -> Iterator[tuple[T, StepAnswers]]:
        """Yield the result with none of the held conditions true, and with each of them true."""
        choices, given, related, words = self._choices, self._given, self._related, self._words
        seen: set[tuple[bool, ...]] = set()
        for begins in (None, *held):
            self._given, self._related = dict(given), related
            if begins is not None and not self._take(begins, words, wanted=True):
                continue
            for other in held:
                if not self._take(other, words, wanted=False):
                    self._take(other, words, wanted=True)
            truths = tuple(self._given[each] for each in held)
            if truths in seen:
                continue
            seen.add(truths)
            moment = self._moment()
            if any(truths):
                self._begun = dict(zip(held, truths, strict=True))
                yield self._run(step, choices), moment
                self._begun = {}
            else:
                yield result, moment
        self._choices = choices

    def _take(self, condition: int, words: Sequence[str | None], *, wanted: bool) -> bool:
        """Set the answer to a condition, and return whether it is possible."""
        if condition in self._given:
            return self._given[condition] is wanted
        names, facts, kept = self._about(condition)
        answer = self._ask(condition, facts, words)[0 if wanted else 1]
        if answer.possible:
            self._keep(condition, names, facts, kept, answer, truth=wanted)
        return answer.possible

    def _asking(self, index: int, it: Any) -> Any:
        if isinstance(it, Branch):
            asking = self._expression(it.condition, None)
            return it._replace(condition=self._noting(asking, it.place))
        triggers = tuple(
            trigger
            if trigger.condition is None
            else trigger._replace(
                condition=self._expression(
                    trigger.condition, (index, number) if trigger.held_s > 0 else None
                )
            )
            for number, trigger in enumerate(it.triggers)
        )
        return it._replace(triggers=triggers)

    def _noting(self, asking: Expression, place: str) -> Expression:
        """Return the condition of a branch, which records its answers."""
        answers = self.branches.setdefault(place, set())
        ask, regions = asking.evaluate, self._conditions.regions(asking.tree)

        def evaluate(numbers: Sequence[float], words: Sequence[str | None]) -> object:
            truth = ask(numbers, words)
            start = self._start
            moved = any(words[each] != start[each] for each in regions) if start else False
            answers.add(BranchAnswers(truth is True, moved))
            return truth

        object.__setattr__(asking, "evaluate", evaluate)
        return asking

    def _expression(self, real: Expression, held: Trigger | None) -> Expression:
        """Return the asking condition; ``held`` is the trigger that must hold it, if any."""
        asking = Expression(real.text, real.type, real.tree)
        number = self._numbers.setdefault(real.tree, len(self._nodes))
        if number == len(self._nodes):
            self._nodes.append(real.tree)
            self._names.append(self._conditions.free(real.tree))

        def evaluate(numbers: Sequence[float], words: Sequence[str | None]) -> bool:
            if held is not None and held not in self._due:
                self._held.setdefault(held[0], {})[number] = None
                self._words = words
                return self._begun.get(number, False)
            return self._answer(number, words)

        object.__setattr__(asking, "evaluate", evaluate)
        return asking

    def _answer(self, condition: int, words: Sequence[str | None]) -> bool:
        """Return whether the condition is true now; false also means unknown."""
        given = self._given.get(condition)
        if given is not None:
            return given
        if len(self._given) == MOST_QUESTIONS:
            raise TooManyQuestionsError
        names, facts, kept = self._about(condition)
        yes, no = self._ask(condition, facts, words)
        chosen = self._choose() if yes.possible and no.possible else yes.possible
        self._keep(condition, names, facts, kept, yes if chosen else no, truth=chosen)
        return chosen

    def _about(
        self, condition: int
    ) -> tuple[frozenset[str], tuple[tuple[int, bool], ...], tuple[Related, ...]]:
        """Return the names and facts related to the condition, and the unrelated answers."""
        names = self._names[condition]
        touched = [each for each in self._related if each.names & names]
        if not touched:
            return names, (), self._related
        facts = tuple(fact for each in touched for fact in each.facts)
        kept = tuple(each for each in self._related if not each.names & names)
        return names.union(*(each.names for each in touched)), facts, kept

    def _keep(
        self,
        condition: int,
        names: frozenset[str],
        facts: tuple[tuple[int, bool], ...],
        kept: tuple[Related, ...],
        answer: PossibleAnswer,
        *,
        truth: bool,
    ) -> None:
        self._given[condition] = truth
        self._related = (*kept, Related(names, (*facts, (condition, truth)), answer))

    def _ask(
        self, condition: int, facts: tuple[tuple[int, bool], ...], words: Sequence[str | None]
    ) -> tuple[PossibleAnswer, PossibleAnswer]:
        """Return whether the condition can be true given the facts, and whether it can be false."""
        key = condition, facts, tuple(words[: self._conditions.region_count])
        if key not in self._known:
            node = self._nodes[condition]
            others = [(self._nodes[number], truth) for number, truth in facts]
            self._known[key] = (
                self._conditions.ask((*others, (node, True)), words),
                self._conditions.ask((*others, (node, False)), words),
            )
        self._conditions.tests += 1
        return self._known[key]

    def _choose(self) -> bool:
        if self._taken == len(self._choices):
            self._choices.append(False)
        self._taken += 1
        return self._choices[self._taken - 1]
