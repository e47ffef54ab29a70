"""Borders of comparisons with one signal, and values between them."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from checking.exploring.conditions_by_lot import VALUES, VOCABULARY
from pirate_sm.checking.exploring.signal_ranges import (
    ANYTHING,
    Range,
    borders,
    is_linear,
    samples,
    signals,
)
from pirate_sm.core.expressions import compile_condition, tree

SPAN = Range(0.0, 2.0)


def comparison(text: str) -> tree.Compare:
    node = compile_condition(text, VOCABULARY).tree
    assert isinstance(node, tree.Compare)
    return node


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a > 1", {1.0}),
        ("2 * a - 1 <= 0", {0.5}),
        ("abs(a - 1) < 0.5", {0.5, 1.0, 1.5}),
        ("max(a, 1) > 1.5", {1.0, 1.5}),
        ("min(a, 10, 2 - a) > 0.5", {0.5, 1.0, 1.5}),  # the first and the third argument cross
    ],
)
def test_borders_are_where_the_comparison_or_its_slope_changes(
    text: str, expected: set[float]
) -> None:
    assert {round(each, 9) for each in borders(comparison(text), SPAN)} >= expected


@settings(max_examples=settings.default.max_examples * 3)
@given(
    left=VALUES, right=VALUES, operator=st.sampled_from(["<", "<=", ">", ">="]),
    part=st.floats(0.01, 0.99),
)  # fmt: skip
def test_between_two_borders_nothing_changes(
    left: str, right: str, operator: str, part: float
) -> None:
    text = f"{left} {operator} {right}"
    expression = compile_condition(text, VOCABULARY)
    assert isinstance(expression.tree, tree.Compare)
    compare = expression.tree
    assume(signals(compare) == ("a",) and is_linear(compare.left) and is_linear(compare.right))

    def at(value: float) -> object:
        return expression.evaluate((value, math.nan, math.nan), ("Up", None, None))

    marks = sorted({0.0, 2.0, *(x for x in borders(compare, SPAN) if 0 <= x <= 2)})
    for low, high in pairwise(marks):
        if high - low > 1e-9:
            assert at(low + part * (high - low)) == at((low + high) / 2)


def test_samples_are_on_borders_between_them_and_beyond() -> None:
    assert samples({0.5, 1.0}, SPAN) == (0.5, 1.0, 0.75, 0.0, 2.0)
    assert set(samples({1.0}, ANYTHING)) == {0.0, 1.0, 2.0}


def test_samples_never_leave_the_range() -> None:
    assert samples({-5.0, 7.0}, SPAN) == (1.0,)
    assert samples((), ANYTHING) == (0.0,)
    assert all(0.0 <= each <= 2.0 for each in samples({0.0, 1.9, 2.0, 3.0}, SPAN))


@pytest.mark.parametrize(
    ("text", "root"),
    [("2 * a >= 4", 2.0), ("2 * a <= 0", 0.0), ("abs(a - 1) >= a / 2", 2.0)],
)
def test_a_root_at_an_end_of_the_range_is_a_border(text: str, root: float) -> None:
    """It may be the only value at which the comparison is true."""
    assert root in borders(comparison(text), SPAN)


def test_a_root_at_a_kink_is_a_border() -> None:
    assert 1.0 in borders(comparison("abs(2 * a - 2) <= 0"), SPAN)
