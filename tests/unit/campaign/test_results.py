"""When a campaign is good, and what is written about one that is not."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.campaign.chunk import Row
from pirate_sm.campaign.results import CampaignResult, as_text, result_of
from pirate_sm.campaign.tally import Tally
from pirate_sm.model.campaign import Expectation, StoppingRule

from .rows import cell, plan, row

LENIENT = Expectation(success=0.5, truthful=0.5, safe=0.5)


def result(*rows: Row, expect: Expectation = LENIENT) -> CampaignResult:
    """The result of a campaign of one cell with four seeds."""
    wanted = cell(seeds=range(4), expect=expect)
    counted = Tally(wanted, 0.95, StoppingRule())
    counted.add(rows)
    return result_of(plan(wanted), [counted], Path("results"))


def passing(*seeds: int) -> list[Row]:
    return [row("key_bend", seed) for seed in seeds]


def test_a_campaign_without_a_missed_expectation_is_good() -> None:
    found = result(*passing(0, 1, 2, 3))

    assert found.good
    assert found.summary == "4 runs of 1 cell: as expected"


def test_a_run_that_crashed_the_program_is_never_good() -> None:
    found = result(*passing(0, 1, 2), row("key_bend", 3, "bug", "KeyError: 'wheel_7'"))

    assert found.cells[0].missed == ()
    assert not found.cells[0].good
    assert not found.good
    assert not found.as_data()["good"]
    assert found.summary == "4 runs of 1 cell: 1 not as expected"
    assert "1 × bug: KeyError: 'wheel_7' (seeds 3)" in as_text(found)


@pytest.mark.parametrize(("least", "good"), [(1.0, False), (0.75, True), (None, True)])
def test_a_run_that_broke_safety_is_good_only_where_that_is_allowed(
    least: float | None, good: bool
) -> None:
    unsafe = row("key_bend", 3, unsafe="a wheel turns at the end")

    found = result(*passing(0, 1, 2), unsafe, expect=Expectation(safe=least))

    assert found.good == good
    assert "1 × unsafe: a wheel turns at the end (seeds 3)" in as_text(found)
    assert ("BELOW EXPECTED: safe" in as_text(found)) == (not good)


def test_a_campaign_that_lacks_a_seed_is_not_good() -> None:
    found = result(*passing(0, 2, 3))

    (only,) = found.cells
    assert (only.good, only.runs, only.without_result, only.first_without) == (True, 1, 1, 1)
    assert not found.good
    assert found.summary == "1 runs of 1 cell: 1 not complete"
    assert "no result for 1 of 4 seeds, the first is 1" in as_text(found)


def test_without_runs_there_is_no_share() -> None:
    (only,) = result().cells

    assert (only.share, only.least, only.most, only.times_s) == (None, None, None, ())
    assert only.summary == "no runs"


def test_the_numbers_of_a_cell() -> None:
    found = result(
        row("key_bend", 0, time_s=30.0, short_m=0.004, deepest_m=0.001),
        row("key_bend", 1, time_s=20.0),
        row("key_bend", 2, time_s=28.0),
        row("key_bend", 3, "failed", time_s=90.0),
    )

    (only,) = found.cells
    assert only.share == 0.75
    assert only.times_s == (20.0, 28.0, 30.0)
    assert (only.farthest_short_m, only.deepest_m) == (0.004, 0.001)
    assert only.expected == "success >= 50 %, truthful >= 50 %, safe >= 50 %"


def test_the_most_frequent_cause_comes_first() -> None:
    found = result(
        row("key_bend", 0, "failed", "Holding"),
        row("key_bend", 1, "failed", "Lost"),
        row("key_bend", 2, "failed", "Lost"),
        row("key_bend", 3, unsafe="a wheel turns at the end"),
    )

    causes = [(each.count, each.why, each.seeds) for each in found.cells[0].causes]
    assert causes == [
        (2, "Lost", (1, 2)),
        (1, "Holding", (0,)),
        (1, "a wheel turns at the end", (3,)),
    ]
