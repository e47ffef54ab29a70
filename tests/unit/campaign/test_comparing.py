"""Whether one campaign is worse than another."""

from __future__ import annotations

import pytest

from pirate_sm.campaign.comparing import compare, comparison_text
from pirate_sm.campaign.tally import Tally
from pirate_sm.model.campaign import StoppingRule

from .rows import cell, row


def tally(name: str, failing: range, runs: int = 200) -> Tally:
    counted = Tally(cell(name, range(runs)), 0.95, StoppingRule())
    verdicts = ("failed" if seed in failing else "passed" for seed in range(runs))
    counted.add(row(f"key_{name}", seed, verdict) for seed, verdict in enumerate(verdicts))
    return counted


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
        # Chances 0.011, 0.020 and 0.037: each at most 5 % shared among those that are left.
        ((10, 9, 8), (True, True, True)),
        # Chances 0.020, 0.037 and 0.037: the smallest is more than a third of 5 %.
        ((9, 8, 8), (False, False, False)),
        # Chances 0.006, 0.037 and 0.037: after the first, 0.037 is more than a half of 5 %.
        ((11, 8, 8), (True, False, False)),
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
