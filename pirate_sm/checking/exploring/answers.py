"""Answers to questions about conditions: which can be true together, with which values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeAlias

from pirate_sm.core.expressions import tree

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
