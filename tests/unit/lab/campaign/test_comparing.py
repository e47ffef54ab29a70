"""Whether one campaign is worse than another."""

from __future__ import annotations

from collections.abc import Container

import pytest

from pirate_sm.lab.campaign.campaign_model import StoppingRule
from pirate_sm.lab.campaign.comparing import CellDifference, compare, comparison_text
from pirate_sm.lab.campaign.tally import Tally

from .rows import cell, row


def tally(name: str, failing: Container[int], runs: int = 200, first: int = 0) -> Tally:
    seeds = range(first, first + runs)
    counted = Tally(cell(name, seeds), 0.95, StoppingRule())
    counted.add(
        row(f"key_{name}", seed, "failed" if seed in failing else "passed") for seed in seeds
    )
    return counted


def test_runs_with_the_same_seeds_are_compared_in_pairs() -> None:
    compared = compare([tally("a", range(25), 50)], [tally("a", range(33), 50)])
    (only,) = compared.differences

    assert only.chance == pytest.approx(2 * 0.5**8)
    assert (only.test, only.worse) == ("McNemar", True)


def test_runs_with_other_seeds_are_compared_as_independent_ones() -> None:
    compared = compare([tally("a", range(25), 50)], [tally("a", range(100, 133), 50, 100)])
    (only,) = compared.differences

    assert only.chance == pytest.approx(0.1558, abs=1e-4)
    assert (only.test, only.worse) == ("Fisher", False)


@pytest.mark.parametrize(
    ("first", "second", "worse"),
    [
        ((90, 100), (500, 1000), True),
        ((50, 100), (900, 1000), False),
        ((900, 1000), (50, 100), True),
        ((500, 1000), (90, 100), False),
    ],
)
def test_shares_decide_which_is_worse_and_not_how_many_runs_there_are(
    first: tuple[int, int], second: tuple[int, int], worse: bool
) -> None:
    found = CellDifference("bend", first, second, 0.001, "Fisher", (), (), significant=True)

    assert found.worse == worse


def test_runs_that_share_some_seeds_only_are_compared_as_independent_ones() -> None:
    (only,) = compare([tally("a", range(5))], [tally("a", range(3, 7), first=1)]).differences

    assert (only.test, only.passed, only.then) == ("Fisher", (195, 200), (196, 200))
    assert (only.lost, only.gained) == ((5, 6), (1, 2))


def test_one_seed_makes_a_pair() -> None:
    (only,) = compare([tally("a", (), 1)], [tally("a", (), 1)]).differences

    assert only.test == "McNemar"


def test_a_cell_without_runs_has_no_pairs() -> None:
    (only,) = compare([tally("a", (), 50)], [tally("a", (), 0)]).differences

    assert (only.test, only.chance, only.worse) == ("Fisher", 1.0, False)


def test_a_cell_that_was_stopped_earlier_is_compared_by_the_seeds_of_both() -> None:
    (only,) = compare([tally("a", range(2), 40)], [tally("a", range(10), 400)]).differences

    assert only.chance == pytest.approx(2 * 0.5**8)
    assert only.worse, "of the shared seeds, though the share of all of them is better"


def test_as_many_seeds_gained_as_lost_are_no_significant_difference() -> None:
    (only,) = compare([tally("a", range(9))], [tally("a", range(9, 18))]).differences

    assert (only.chance, only.significant, only.worse) == (1.0, False, False)


def test_a_large_difference_is_worse_and_says_which_seeds_were_lost() -> None:
    compared = compare([tally("a", range(2))], [tally("a", range(1, 30))])
    (only,) = compared.differences

    assert compared.worse
    assert only.lost == tuple(range(2, 30))
    assert only.gained == (0,)
    assert "B is worse than A" in comparison_text(compared)


def test_a_difference_that_chance_makes_is_not_worse() -> None:
    compared = compare([tally("a", range(2))], [tally("a", range(6))])

    assert not compared.worse
    assert compared.differences[0].lost == (2, 3, 4, 5)
    assert "B is not significantly worse than A" in comparison_text(compared)


def test_a_better_one_is_significant_and_not_worse() -> None:
    (only,) = compare([tally("a", range(40))], [tally("a", range(2))]).differences

    assert (only.significant, only.worse) == (True, False)


def test_of_many_cells_one_may_look_worse_by_chance() -> None:
    one = [tally("a", range(1)), *(tally(str(n), range(5)) for n in range(9))]
    other = [tally("a", range(8)), *(tally(str(n), range(5)) for n in range(9))]

    assert compare(one[:1], other[:1]).differences[0].significant
    assert not compare(one, other).worse


@pytest.mark.parametrize(
    ("failing", "significant"),
    [
        # Chances 0.016, 0.016 and 0.031: each at most 5 % shared among those that are left.
        ((8, 8, 7), (True, True, True)),
        # Chances 0.031 of all: the smallest is more than a third of 5 %.
        ((7, 7, 7), (False, False, False)),
        # Chances 0.016, 0.031 and 0.031: after the first, 0.031 is more than a half of 5 %.
        ((8, 7, 7), (True, False, False)),
    ],
)
def test_the_smaller_chances_of_several_cells_make_way_for_the_larger_ones(
    failing: tuple[int, ...], significant: tuple[bool, ...]
) -> None:
    before = [tally(str(cell), range(1)) for cell in range(3)]
    after = [tally(str(cell), range(count)) for cell, count in enumerate(failing)]

    found = compare(before[::-1], after).differences[::-1]

    assert tuple(each.significant for each in found) == significant


def test_cells_of_one_campaign_alone_are_named() -> None:
    compared = compare([tally("a", range(1)), tally("b", range(1))], [tally("c", range(1))])

    assert (compared.only_first, compared.only_second) == (("a", "b"), ("c",))
    assert "no cell is in both" in comparison_text(compared)


def partly(name: str, failing: range, runs: int, of: int) -> Tally:
    """A cell that has the first of its runs only."""
    counted = Tally(cell(name, range(of)), 0.95, StoppingRule())
    verdicts = ("failed" if seed in failing else "passed" for seed in range(runs))
    counted.add(row(f"key_{name}", seed, verdict) for seed, verdict in enumerate(verdicts))
    return counted


def test_a_cell_that_is_not_complete_is_compared_by_what_it_has() -> None:
    (only,) = compare([partly("a", range(2), 5, 20)], [partly("a", range(1, 4), 4, 9)]).differences

    assert only.test == "McNemar"
    assert (only.passed, only.then) == ((3, 5), (1, 4))
    assert (only.lost, only.gained) == ((2, 3), (0,))


def test_what_is_written_for_people() -> None:
    first = [tally("a", range(10)), tally("cell_b", range(30), 2_000), tally("gone", range(1))]
    second = [
        tally("cell_b", range(20, 80), 2_000),
        tally("a", range(1)),
        partly("new", range(1), 0, 5),
    ]

    assert comparison_text(compare(first, second)).splitlines() == [
        "                      A passed                B passed  by chance  test",
        "a            190 of 200  95.0%       199 of 200  99.5%     0.0039  McNemar  better",
        "    9 gained in B: seeds 1, 2, 3, 4, 5, 6, 7, 8, 9",
        "cell_b   1,970 of 2,000  98.5%   1,940 of 2,000  97.0%    0.00044  McNemar  WORSE",
        "    50 lost in B: seeds 30, 31, 32, 33, 34, 35, 36, 37, 38, 39, …",
        "    20 gained in B: seeds 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, …",
        "gone: only in A",
        "new: only in B",
        "B is worse than A",
    ]


def test_ten_seeds_are_written_without_dots() -> None:
    text = comparison_text(compare([tally("a", range(0))], [tally("a", range(10))]))

    assert "    10 lost in B: seeds 0, 1, 2, 3, 4, 5, 6, 7, 8, 9\n" in text
    assert text.endswith("B is worse than A\n")


def test_without_a_cell_in_both_there_is_the_head_alone() -> None:
    (no_runs,) = compare([partly("a", range(0), 0, 5)], [tally("a", range(1))]).differences
    text = comparison_text(compare([], []))

    assert (no_runs.chance, no_runs.significant) == (1.0, False)
    head = f"{'':2}{'A passed':>22}  {'B passed':>22}  by chance  test"
    assert text.splitlines() == [head, "no cell is in both"]
