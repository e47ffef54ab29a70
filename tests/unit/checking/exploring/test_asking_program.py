"""Every answer that conditions can give in one step, once."""

from __future__ import annotations

import pytest

from checking.exploring.conditions_by_lot import STATES, VOCABULARY, conditions
from pirate_sm.checking.exploring import asking_program as module
from pirate_sm.checking.exploring.asking_program import Oracle
from pirate_sm.checking.exploring.conditions import TooManyQuestionsError
from pirate_sm.core.expressions import compile_condition
from pirate_sm.core.program import Branch, Program

WORDS = STATES[0]


def every(*texts: str) -> list[tuple[bool, ...]]:
    """The answers to these conditions, asked one after the other in one step."""
    oracle = Oracle(conditions())
    branches = [Branch(compile_condition(text, VOCABULARY), 0, 0, "") for text in texts]
    program = Program(tuple(branches), 0, 0, ((),) * len(texts), (), ("",) * len(texts), 9)
    asked = [each for each in oracle.program(program).instructions if isinstance(each, Branch)]

    def step() -> tuple[bool, ...]:
        return tuple(each.condition.evaluate((), WORDS) is True for each in asked)

    results = []
    for result, moment in oracle.every(step):
        assert moment.answer.possible
        assert len(moment.facts) == len(set(texts))
        results.append(result)
    return results


def test_what_is_free_is_tried_both_ways() -> None:
    assert sorted(every("a > 1")) == [(False,), (True,)]
    assert len(every("a > 1", "b > 0", "light == red")) == 8


def test_what_cannot_be_together_is_not_tried() -> None:
    assert sorted(every("a > 1", "a < 0.5")) == [(False, False), (False, True), (True, False)]
    assert sorted(every("a > 1", "a > 0.5")) == [(False, False), (False, True), (True, True)]


def test_what_is_known_has_one_answer() -> None:
    assert every("Arm == Up", "true", "a > 3") == [(True, True, False)]


def test_the_same_question_has_the_same_answer_in_one_moment() -> None:
    assert sorted(every("a > 1", "a > 1")) == [(False, False), (True, True)]


def test_conditions_that_share_signals_through_others_do_not_contradict_each_other() -> None:
    answers = every("a > 1", "b > 0", "a < 0.5 or b < -0.5")

    assert (True, True, True) not in answers
    assert len(answers) == 7


def test_more_questions_than_can_be_answered_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_QUESTIONS", 2)

    with pytest.raises(TooManyQuestionsError):
        every("a > 1", "b > 0", "c > 0")
