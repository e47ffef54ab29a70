"""Answers to questions about conditions: what can be true together, and with which values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeAlias

from pirate_sm.expressions import tree

Fact: TypeAlias = tuple[tree.Node, bool]
"""A condition, and whether it is true; false stands for false and for unknown."""


class PossibleAnswer(NamedTuple):
    """Whether it can be so.

    Attributes:
        sure: False where a *yes* rests on something that is not decided here.
        numbers: Signals with which it is so; words likewise.
    """

    possible: bool
    sure: bool = True
    numbers: Mapping[str, float] = {}
    words: Mapping[str, str | None] = {}


def together(answers: Iterable[PossibleAnswer]) -> PossibleAnswer:
    """Return the answer to several questions that have no signal in common."""
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
    """What was answered in one run of a step.

    Attributes:
        answer: Whether that can be, how surely, and signals with which it is so.
    """

    facts: tuple[Fact, ...]
    answer: PossibleAnswer


Trigger: TypeAlias = tuple[int, int]
"""Index of a wait, and number of one of its triggers."""

NOWHERE = -1
"""Stands for the wait of a result that does not wait."""


class TooManyQuestionsError(Exception):
    """A step of the engine asks about more conditions than can be answered together."""


class Related(NamedTuple):
    """What has been answered about conditions that share signals, directly or by others.

    Attributes:
        facts: Numbers of conditions, and whether they are true.
    """

    names: frozenset[str]
    facts: tuple[tuple[int, bool], ...]
    answer: PossibleAnswer


class BranchAnswers(NamedTuple):
    """What a branch has asked.

    Attributes:
        moved: Whether it is about a state that is another one than at the start.
    """

    truth: bool
    moved: bool
