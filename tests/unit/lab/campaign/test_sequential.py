"""A test that looks after each run errs no more often than it says, and so do its intervals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.lab.campaign.intervals import Interval, wilson
from pirate_sm.lab.campaign.sequential import DOUBTFUL, FAILS, HOLDS, SequentialTest

USUAL = SequentialTest(0.9, 0.0125, 200)


def ended(test: SequentialTest, passes: np.ndarray) -> tuple[str, int, int]:
    """Return how a test ends with these runs: its verdict, passed runs, and runs."""
    passed = 0
    for runs, each in enumerate(passes.tolist(), start=1):
        passed += each
        if (verdict := test.verdict(passed, runs)) is not None:
            return verdict, passed, runs
    raise AssertionError("it never ends")


def chance(test: SequentialTest, share: float, wanted: str) -> float:
    """Return how likely a test ends so, by the chances of all numbers of passes, run by run."""
    chances, total = {0: 1.0}, 0.0
    for runs in range(1, test.most + 1):
        further: dict[int, float] = {}
        for passed, likely in chances.items():
            for more, times in ((1, share), (0, 1.0 - share)):
                further[passed + more] = further.get(passed + more, 0.0) + likely * times
        verdicts = {passed: test.verdict(passed, runs) for passed in further}
        total += sum(further[passed] for passed, verdict in verdicts.items() if verdict == wanted)
        chances = {passed: each for passed, each in further.items() if verdicts[passed] is None}
    return total


@given(
    share=st.floats(0.05, 0.95),
    error=st.floats(0.001, 0.2),
    most=st.integers(1, 60),
    away=st.floats(0.0, 1.0),
)
def test_each_error_is_at_most_as_likely_as_it_says(
    share: float, error: float, most: int, away: float
) -> None:
    test = SequentialTest(share, error, most)

    assert chance(test, share * (1.0 - away), HOLDS) <= error + 1e-9
    assert chance(test, share + (1.0 - share) * away, FAILS) <= error + 1e-9


def test_clear_cases_end_early() -> None:
    assert ended(USUAL, np.ones(200, dtype=bool))[::2] == (HOLDS, 49)
    assert ended(USUAL, np.zeros(200, dtype=bool)) == (FAILS, 0, 3)
    assert ended(USUAL, np.arange(200) % 10 > 0)[::2] == (DOUBTFUL, 200)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8, 0.9, 0.95, 0.99])
def test_intervals_cover_the_share_and_are_little_wider_than_those_of_fixed_numbers_of_runs(
    share: float,
) -> None:
    known: dict[tuple[int, int], Interval] = {}
    covered, widths, usual = 0, 0.0, 0.0
    rng = np.random.default_rng(20)
    for passes in rng.random((2_000, USUAL.most)) < share:
        _, passed, runs = ended(USUAL, passes)
        at = passed, runs
        if at not in known:
            known[at] = USUAL.interval(passed, runs, 0.95)
        covered += known[at].least <= share <= known[at].most
        widths += known[at].half_width
        usual += wilson(passed, runs, 0.95).half_width

    assert covered >= 0.935 * 2_000
    assert widths <= 1.2 * usual


@pytest.mark.parametrize(
    ("share", "error"), [(0.9, 0.0125), (0.98, 0.0125), (0.8, 0.05), (0.5, 0.01), (0.05, 0.0125)]
)
def test_with_the_least_runs_a_test_can_end_both_ways_and_with_one_fewer_it_cannot(
    share: float, error: float
) -> None:
    def ends(most: int) -> set[str | None]:
        test = SequentialTest(share, error, most)
        return {test.verdict(most, most), test.verdict(0, most)}

    least = SequentialTest(share, error, 200).least

    assert ends(least) == {HOLDS, FAILS}
    assert DOUBTFUL in ends(least - 1)
