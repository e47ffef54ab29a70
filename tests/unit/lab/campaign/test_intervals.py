"""Intervals of shares and the test of two shares agree with SciPy's."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import pytest

from pirate_sm.lab.campaign.intervals import Interval, fisher_exact, mcnemar_exact, wilson


@pytest.fixture(scope="module")
def stats() -> Any:
    """SciPy's statistics, which take a second to import."""
    return import_module("scipy.stats")


@pytest.mark.parametrize(
    ("passed", "runs"), [(0, 1), (1, 1), (0, 40), (40, 40), (991, 1000), (17, 23), (5, 10**6)]
)
@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.999])
def test_wilsons_interval(stats: Any, passed: int, runs: int, confidence: float) -> None:
    expected = stats.binomtest(passed, runs).proportion_ci(confidence, method="wilson")

    assert wilson(passed, runs, confidence) == pytest.approx(tuple(expected), abs=1e-9)


def test_half_the_width_of_an_interval_is_how_far_a_share_may_be_off() -> None:
    assert Interval(0.5, 0.75).half_width == 0.125


def test_without_runs_nothing_is_known() -> None:
    assert wilson(0, 0, 0.95) == (0.0, 1.0)


@pytest.mark.parametrize(
    "table",
    [
        (10, 10, 10, 10),
        (0, 5, 5, 5),
        (98, 100, 90, 100),
        (990, 1000, 999, 1000),
        (3, 7, 1, 12),
        (297, 300, 982, 1000),
        (0, 20, 0, 30),
        (99_000, 100_000, 98_800, 100_000),
        (5, 6, 5, 14),  # another table is as likely, but for rounding
        (1, 3, 1, 5),  # the chances of all tables add up to a little more than 1
    ],
)
def test_fishers_exact_test(stats: Any, table: tuple[int, int, int, int]) -> None:
    a, n, b, m = table
    expected = stats.fisher_exact([[a, n - a], [b, m - b]]).pvalue

    assert fisher_exact(a, n, b, m) == pytest.approx(expected, rel=1e-6)
    assert fisher_exact(b, m, a, n) == pytest.approx(expected, rel=1e-6)
    assert fisher_exact(a, n, b, m) <= 1.0


@pytest.mark.parametrize(
    ("lost", "gained"), [(0, 0), (8, 0), (0, 1), (5, 5), (30, 12), (12, 30), (51_000, 50_000)]
)
def test_mcnemars_exact_test(stats: Any, lost: int, gained: int) -> None:
    changed = lost + gained
    expected = stats.binomtest(lost, changed).pvalue if changed else 1.0

    assert mcnemar_exact(lost, gained) == pytest.approx(expected, rel=1e-6)
