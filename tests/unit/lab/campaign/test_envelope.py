"""The search for an edge finds it, from results in any order, and says where it assumes."""

from __future__ import annotations

from collections.abc import Callable
from math import exp, log
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.lab.campaign.envelope import Envelope, envelope, look
from pirate_sm.lab.campaign.margins_model import MarginFactor, Margins
from pirate_sm.lab.campaign.sequential import DOUBTFUL, FAILS, HOLDS, SequentialTest, Verdict

FRICTION = MarginFactor("friction", "", 0.0, 1.0, 0.5)


def searched(
    factor: MarginFactor, truth: Callable[[float], Verdict], seed: int = 0, **how: int
) -> Envelope:
    """Return what a search finds that learns wanted verdicts one by one, in an order of chance."""
    known, random = dict[float, Verdict](), Random(seed)
    levels, halvings = how.get("levels", 4), how.get("halvings", 3)
    for _ in range(200):
        found = envelope(factor, lambda at: known.get(next(iter(at.values()))), levels, halvings)
        if not found.wanted:
            return found
        value = random.choice(found.wanted)
        known[value] = truth(value)
    raise AssertionError("it never ends")


@given(
    low=st.floats(0.0, 0.5),
    high=st.floats(0.5, 1.0),
    doubt=st.floats(0.0, 0.2),
    levels=st.integers(1, 6),
    halvings=st.integers(0, 5),
)
def test_edges_of_a_monotone_factor_are_found_as_near_as_the_last_halving(
    low: float, high: float, doubt: float, levels: int, halvings: int
) -> None:
    def truth(value: float) -> Verdict:
        outside = max(low - value, value - high)
        return HOLDS if outside <= 0.0 else DOUBTFUL if outside <= doubt else FAILS

    found = searched(FRICTION, truth, levels=levels, halvings=halvings)
    near = 0.5 / levels / 2**halvings + 2e-3  # values have four digits

    assert 0.0 <= found.below.edge - low <= near
    assert 0.0 <= high - found.above.edge <= near
    assert found.above.again == found.below.again == ()
    assert found.above.fails is None or found.above.fails > high + doubt


@pytest.mark.parametrize("seed", range(6))
def test_the_order_in_which_results_come_changes_nothing(seed: int) -> None:
    def truth(value: float) -> Verdict:
        return HOLDS if 0.31 <= value <= 0.93 else FAILS

    assert searched(FRICTION, truth, seed) == searched(FRICTION, truth)


def test_success_that_comes_back_behind_an_edge_is_reported_and_not_part_of_the_margin() -> None:
    def truth(value: float) -> Verdict:
        return FAILS if 0.6 < value < 0.7 else HOLDS

    above = searched(FRICTION, truth).above

    assert 0.57 < above.edge <= 0.6
    assert above.again == (0.75, 0.875, 1.0)
    assert above.fails == 0.6094


def test_a_wanted_value_is_tried_itself() -> None:
    side = look(FRICTION, 1.0, lambda value: HOLDS, 2, 3, also=[0.8])

    assert [value for value, _ in side.tried] == [0.75, 0.8, 1.0]
    assert side.whole


def test_a_factor_with_one_side_is_looked_at_there_alone() -> None:
    late = MarginFactor("sticks:after", "s", 0.0, 60.0, 60.0)
    found = searched(late, lambda value: HOLDS if value >= 31.0 else FAILS)

    assert found.above.tried == ()
    assert len(found.below.tried) == 8 + 3
    assert 31.0 <= found.below.edge < 32.0


def too_far(repetitions: int) -> float:
    """Return how often an edge of a logistic success is found beyond the true one."""
    wanted = Margins(share=0.9, halvings=2, runs=100)
    test: SequentialTest = wanted.test(0.95)
    steep, middle = 30.0, 0.8
    edge = middle - log(wanted.share / (1.0 - wanted.share)) / steep
    rng, beyond = np.random.default_rng(7), 0

    def truth(value: float) -> Verdict:
        passed, share = 0, 1.0 / (1.0 + exp(steep * (value - middle)))
        for runs, each in enumerate((rng.random(test.most) < share).tolist(), start=1):
            passed += each
            if (verdict := test.verdict(passed, runs)) is not None:
                return verdict
        raise AssertionError

    for _ in range(repetitions):
        found = searched(FRICTION, truth, levels=5, halvings=wanted.halvings)
        beyond += found.above.edge > edge
        assert found.above.edge > 0.5, "with 0.998 it is seen to hold at the first value"
    return beyond / repetitions


def test_the_edge_of_a_logistic_success_is_rarely_found_too_far_out() -> None:
    assert too_far(300) <= 0.05


@pytest.mark.thorough
def test_the_edge_is_found_too_far_out_as_rarely_as_is_said() -> None:
    assert too_far(2_000) <= 0.05
