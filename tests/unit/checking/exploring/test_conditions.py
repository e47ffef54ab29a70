"""What can be true together, held against trying."""

from __future__ import annotations

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from checking.exploring.conditions_by_lot import (
    FACTS,
    STATES,
    conditions,
    facts_of,
    hold,
    somewhere,
)


def possible(*texts: str, state: str = "Up", but_not: tuple[str, ...] = ()) -> bool:
    facts = facts_of([*((text, True) for text in texts), *((text, False) for text in but_not)])
    return conditions().ask(facts, (state, None, None)).possible


@pytest.mark.thorough
@settings(max_examples=settings.default.max_examples * 4)
@given(facts=FACTS, states=st.sampled_from(STATES), seed=st.integers(0, 2**32))
def test_what_is_called_impossible_is_never_found(
    facts: list[tuple[str, bool]], states: tuple[str, ...], seed: int
) -> None:
    answer = conditions().ask(facts_of(facts), states)

    if not answer.possible:
        assert somewhere(facts, states[0], Random(seed)) is None


@pytest.mark.thorough
@settings(max_examples=settings.default.max_examples * 4)
@given(facts=FACTS, states=st.sampled_from(STATES))
def test_what_is_called_sure_is_so_with_the_values_given(
    facts: list[tuple[str, bool]], states: tuple[str, ...]
) -> None:
    answer = conditions().ask(facts_of(facts), states)

    if answer.possible and answer.sure:
        assert hold(facts, answer.numbers, {"Arm": states[0], **answer.words})


@settings(max_examples=settings.default.max_examples * 2)
@given(facts=FACTS, states=st.sampled_from(STATES))
def test_a_question_has_one_answer_in_whatever_order_it_is_asked(
    facts: list[tuple[str, bool]], states: tuple[str, ...]
) -> None:
    asked = conditions()
    first = asked.ask(facts_of(facts), states)

    assert asked.ask(facts_of(facts), states) == first
    assert conditions().ask(facts_of(facts)[::-1], states).possible == first.possible


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (("a > 1", "a < 0.5"), False),
        (("a > 1", "a < 1.5"), True),
        (("a > 2",), False),  # beyond its range
        (("a >= 2",), True),
        (("abs(b) > 1",), False),
        (("a > 1", "not known(a)"), False),
        (("not known(a)", "b > 0"), True),
        (("min(a, 10, 2 - a) > 0.9",), True),  # only near 1
        (("min(a, 10, 2 - a) > 1.01",), False),
        (("light == red", "light == green"), False),
        (("Arm == Down",), False),  # the state is known
        (("a > b", "a < b"), True),  # two signals are not compared here
        (("a / 0 > 1",), False),  # unknown whatever a is
    ],
)
def test_contradictions_within_one_signal_are_seen(texts: tuple[str, ...], expected: bool) -> None:
    assert possible(*texts) is expected


def test_false_stands_for_unknown_too() -> None:
    assert possible(but_not=("a >= 0",))
    assert not possible("known(a)", but_not=("a >= 0",))


def test_what_compares_two_signals_is_not_sure_unless_values_show_it() -> None:
    asked = conditions()

    shown = asked.ask(facts_of([("a > b", True)]), STATES[0])
    hidden = asked.ask(facts_of([("a * a == 1.7 and c < a", True)]), STATES[0])

    assert shown.possible
    assert shown.sure
    assert hidden.possible
    assert not hidden.sure


def test_what_would_take_too_long_is_assumed_and_not_sure() -> None:
    many = [(f"a < {number / 500} or b < {number / 700} or c < {number}", True)
            for number in range(100)]  # fmt: skip
    asked = conditions()

    answer = asked.ask(facts_of(many), STATES[0])

    assert answer.possible
    assert not answer.sure
    assert asked.tests < 1_000


def test_a_comparison_of_numbers_alone_is_not_free() -> None:
    undecided = "a * b > c * c + 1000"

    assert possible(undecided)
    assert not possible("1 > 2", undecided)
    assert not possible(f"1 > 2 and {undecided}")
    assert possible(f"2 > 1 and {undecided}")


def test_what_is_divided_by_something_that_may_be_zero_may_be_unknown() -> None:
    answer = conditions().ask(
        facts_of([("known(a)", True), ("known(1 / (a * a - 1.7))", False)]), STATES[0]
    )

    assert answer.possible
    assert not answer.sure
