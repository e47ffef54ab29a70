"""A program whose conditions ask instead of looking: every answer that is possible is given once.

The engine runs as it always does. Where it evaluates a condition of the mission, the answer comes
from a list of choices; by running the same step again with other choices, everything that sensors
could have said at that moment has been tried. Answers of one moment never contradict each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

from pirate_sm.checking.exploring.conditions import Answer, Conditions, Fact
from pirate_sm.engine.program import Branch, Program, Wait
from pirate_sm.expressions import Expression

T = TypeVar("T")


class Moment(NamedTuple):
    """What was answered in one run of a step.

    Attributes:
        answer: Whether that can be, how surely, and signals with which it is so.
    """

    facts: tuple[Fact, ...]
    answer: Answer


class Oracle:
    """Gives the answers.

    Args:
        conditions: Knows what can be true together.
    """

    def __init__(self, conditions: Conditions) -> None:
        self._conditions = conditions
        self._facts: list[Fact] = []
        self._choices: list[bool] = []
        self._taken = 0
        self._states: Sequence[str | None] = ()

    def program(self, program: Program) -> Program:
        """The same program, asking."""
        instructions = tuple(
            self._asking(each) if isinstance(each, Branch | Wait) else each
            for each in program.instructions
        )
        return replace(program, instructions=instructions)

    def every(self, step: Callable[[], T]) -> Iterator[tuple[T, Moment]]:
        """The result of the step for everything that its conditions can be."""
        pending: list[list[bool]] = [[]]
        while pending:
            self._choices = pending.pop()
            given = len(self._choices)
            self._facts, self._taken = [], 0
            result = step()
            answer = self._conditions.ask(self._facts, self._states)
            yield result, Moment(tuple(self._facts), answer)
            for place in range(len(self._choices) - 1, given - 1, -1):
                pending.append([*self._choices[:place], not self._choices[place]])

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

        def evaluate(numbers: Sequence[float], words: Sequence[str | None]) -> bool:
            return self._answer(real, words)

        object.__setattr__(asking, "evaluate", evaluate)
        return asking

    def _answer(self, condition: Expression, words: Sequence[str | None]) -> bool:
        """Whether the condition is true now; false stands for unknown too."""
        self._states = words
        yes, no = (condition.tree, True), (condition.tree, False)
        if yes in self._facts:
            return True
        if no in self._facts:
            return False
        can = self._conditions.ask((*self._facts, yes), words).possible
        if not can or not self._conditions.ask((*self._facts, no), words).possible:
            self._facts.append(yes if can else no)
            return can
        if self._taken == len(self._choices):
            self._choices.append(False)
        chosen = self._choices[self._taken]
        self._taken += 1
        self._facts.append(yes if chosen else no)
        return chosen
