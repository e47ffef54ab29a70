"""A program whose conditions ask instead of looking: every answer that is possible is given once.

The engine runs as it always does. Where it evaluates a condition of the mission, the answer comes
from a list of choices; by running the same step again with other choices, everything that sensors
could have said at that moment has been tried. Answers of one moment never contradict each other.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

from pirate_sm.checking.exploring.conditions import Answer, Conditions, Fact, together
from pirate_sm.engine.program import Branch, Program, Wait
from pirate_sm.expressions import Expression, tree

T = TypeVar("T")


class Moment(NamedTuple):
    """What was answered in one run of a step.

    Attributes:
        answer: Whether that can be, how surely, and signals with which it is so.
    """

    facts: tuple[Fact, ...]
    answer: Answer


MOST_QUESTIONS = 256
"""About different conditions at one moment; who asks more gets no answer."""


class TooManyQuestionsError(Exception):
    """A step of the engine asks about more conditions than can be answered together."""


class _Related(NamedTuple):
    """What has been answered about conditions that share signals, directly or by others.

    Attributes:
        facts: Numbers of conditions, and whether they are true.
    """

    names: frozenset[str]
    facts: tuple[tuple[int, bool], ...]
    answer: Answer


class Oracle:
    """Gives the answers.

    Args:
        conditions: Knows what can be true together.
    """

    def __init__(self, conditions: Conditions) -> None:
        self._conditions = conditions
        self._numbers: dict[tree.Node, int] = {}
        self._nodes: list[tree.Node] = []
        self._names: list[frozenset[str]] = []
        self._known: dict[Hashable, tuple[Answer, Answer]] = {}
        self._given: dict[int, bool] = {}
        self._related: list[_Related] = []
        self._choices: list[bool] = []
        self._taken = 0

    def program(self, program: Program) -> Program:
        """The same program, asking."""
        instructions = tuple(
            self._asking(each) if isinstance(each, Branch | Wait) else each
            for each in program.instructions
        )
        return replace(program, instructions=instructions)

    def every(self, step: Callable[[], T]) -> Iterator[tuple[T, Moment]]:
        """The result of the step for everything that its conditions can be.

        Raises:
            TooManyQuestionsError: It has too many of them.
        """
        pending: list[list[bool]] = [[]]
        while pending:
            self._choices = pending.pop()
            given = len(self._choices)
            self._given, self._related, self._taken = {}, [], 0
            result = step()
            choices = self._choices
            answer = together(each.answer for each in self._related)
            facts = tuple((self._nodes[number], truth) for number, truth in self._given.items())
            yield result, Moment(facts, answer)
            for place in range(len(choices) - 1, given - 1, -1):
                pending.append([*choices[:place], not choices[place]])

    def _asking(self, it: Any) -> Any:
        if isinstance(it, Branch):
            return it._replace(condition=self._expression(it.condition))
        triggers = tuple(
            trigger
            if trigger.condition is None
            else trigger._replace(condition=self._expression(trigger.condition))
            for trigger in it.triggers
        )
        return it._replace(triggers=triggers)

    def _expression(self, real: Expression) -> Expression:
        asking = Expression(real.text, real.type, real.tree)
        number = self._numbers.setdefault(real.tree, len(self._nodes))
        if number == len(self._nodes):
            self._nodes.append(real.tree)
            self._names.append(self._conditions.free(real.tree))

        def evaluate(numbers: Sequence[float], words: Sequence[str | None]) -> bool:
            return self._answer(number, words)

        object.__setattr__(asking, "evaluate", evaluate)
        return asking

    def _answer(self, condition: int, words: Sequence[str | None]) -> bool:
        """Whether the condition is true now; false stands for unknown too."""
        given = self._given.get(condition)
        if given is not None:
            return given
        if len(self._given) == MOST_QUESTIONS:
            raise TooManyQuestionsError
        names = self._names[condition]
        touched = [each for each in self._related if each.names & names]
        facts = tuple(fact for each in touched for fact in each.facts)
        yes, no = self._ask(condition, facts, words)
        chosen = self._choose() if yes.possible and no.possible else yes.possible
        self._given[condition] = chosen
        self._related = [each for each in self._related if not each.names & names]
        names = names.union(*(each.names for each in touched))
        self._related.append(_Related(names, (*facts, (condition, chosen)), yes if chosen else no))
        return chosen

    def _ask(
        self, condition: int, facts: tuple[tuple[int, bool], ...], words: Sequence[str | None]
    ) -> tuple[Answer, Answer]:
        """Whether the condition can be true beside the facts, and whether it can be false."""
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
