"""When a campaign is good, and what is written about one that is not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule
from pirate_sm.lab.campaign.chunk import RunRow
from pirate_sm.lab.campaign.conductor import recording_name
from pirate_sm.lab.campaign.intervals import wilson
from pirate_sm.lab.campaign.results import CampaignResult, as_text, result_of
from pirate_sm.lab.campaign.store import RECORDINGS
from pirate_sm.lab.campaign.tally import Tally

from .rows import cell, plan, row

LENIENT = Expectation(success=0.5, truthful=0.5, safe=0.5)


def result(*rows: RunRow, expect: Expectation = LENIENT) -> CampaignResult:
    """The result of a campaign of one cell with four seeds."""
    wanted = cell(seeds=range(4), expect=expect)
    counted = Tally(wanted, 0.95, StoppingRule())
    counted.add(rows)
    return result_of(plan(wanted), [counted], Path("results"))


def passing(*seeds: int) -> list[RunRow]:
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


TEXT = """\
                         passed      95% interval  mission time, least/median/most
bend             4 of 16  25.0%    10.2% to 49.5%  120.0/135.0/150.0 s  BELOW EXPECTED: success, safe
       12 × failed: Holding after 4.0 s (seeds 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, …; numbers of seed 0)
            pirate run mitre_bend --seed 0 --speed max --defect wheels_3_4_dead --jitter start=20mm
            recorded in FOLDER/recordings/RECORDING
        1 × unsafe: fell (seeds 13)
            pirate run mitre_bend --seed 13 --speed max --defect wheels_3_4_dead --jitter start=20mm
long_name         0 of 2   0.0%     0.0% to 65.8%  -  BELOW EXPECTED: success
        2 × bug: KeyError: 'x' (seeds 0, 1)
            pirate run mitre_bend --seed 0 --speed max --defect wheels_3_4_dead --jitter start=20mm
none                    no runs
    not complete: no result for 3 of 3 seeds, the first is 0; later ones do not count until the \
campaign's command with --resume has run it
left: not run, a cell before it is not as expected
18 runs of 3 cells: 2 not as expected, 1 not complete
results in FOLDER
"""  # noqa: E501


def test_what_is_written_for_people(tmp_path: Path) -> None:
    wanted = Expectation(success=0.75, safe=1.0)
    seeds = {"bend": range(16), "long_name": range(2), "none": range(3), "left": range(1)}
    cells = [cell(name, each, wanted) for name, each in seeds.items()]
    bend, long, none = (Tally(each, 0.95, StoppingRule()) for each in cells[:3])
    for seed in range(16):
        why = f"Holding after {4 - seed % 2}.0 s"
        verdict = "failed" if seed < 12 else "passed"
        unsafe = "fell" if seed == 13 else ""
        bend.add([row("key_bend", seed, verdict, why, time_s=10.0 * seed, unsafe=unsafe)])
    long.add(row("key_long_name", seed, "bug", "KeyError: 'x'") for seed in range(2))
    recording = tmp_path / RECORDINGS / recording_name(bend, 0)
    recording.parent.mkdir()
    recording.touch()

    found = result_of(plan(*cells), [bend, long, none], tmp_path)

    text = as_text(found).replace(str(tmp_path), "FOLDER")
    assert text == TEXT.replace("RECORDING", recording.name, 1)
    assert (found.name, found.results, found.version) == ("trial", str(tmp_path), "1+a")
    assert [each.recording for each in found.cells[0].causes] == [str(recording), ""]
    assert found.cells[0].summary == "4 of 16 passed, 10.2% to 49.5%"
    assert found.cells[0].deepest_m is None
    assert found.cells[0].incomplete == ""


def test_ten_seeds_of_a_cause_are_written_without_dots() -> None:
    counted = Tally(cell(seeds=range(10)), 0.95, StoppingRule())
    counted.add(row("key_bend", seed, "failed") for seed in range(10))

    assert "(seeds 0, 1, 2, 3, 4, 5, 6, 7, 8, 9)" in as_text(
        result_of(plan(counted.cell), [counted], Path("results"))
    )


def test_a_campaign_of_which_nothing_has_run_says_so() -> None:
    head, *others = as_text(result_of(plan(cell()), [], Path("results"))).splitlines()

    assert head.startswith(f"  {'passed':>20}  ")
    assert others[0] == "bend: not run, a cell before it is not as expected"


def test_each_count_of_a_cell_has_its_place() -> None:
    verdicts = ["failed"] * 6 + ["false"] * 4 + ["bug"] * 3 + ["passed"] * 2
    wanted = replace(cell(seeds=range(25)), column="in 90 mm")
    counted = Tally(wanted, 0.95, StoppingRule())
    for seed, verdict in enumerate(verdicts):
        unsafe = "fell" if seed < 5 else ""
        each = row("key_bend", seed, verdict, unsafe=unsafe, deepest_m=0.0)
        counted.add([each._replace(held=verdict == "passed" or seed == 0)])
    counted.add([row("key_bend", 20)])

    (only,) = result_of(plan(wanted), [counted], Path("results")).cells

    assert (only.name, only.row, only.column) == ("bend: in 90 mm", "bend", "in 90 mm")
    assert (only.runs, only.of, only.passed, only.held) == (15, 25, 2, 3)
    assert (only.false, only.unsafe, only.bugs) == (4, 5, 3)
    assert (only.without_result, only.first_without) == (9, 15)
    assert (only.least, only.most) == (counted.interval.least, counted.interval.most)
    assert only.least is not None
    assert only.most is not None
    assert only.least < 2 / 15 < only.most
    assert only.deepest_m == 0.0
    assert only.missed == ("truthful",)


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


def test_runs_are_counted_by_how_long_they_took_in_thirty_bars() -> None:
    rows = [row("key_bend", seed, time_s=10.0 + 0.4 * seed) for seed in range(3)]
    rows.append(row("key_bend", 3, "failed", time_s=40.0))

    took = result(*rows).cells[0].took

    assert took is not None
    assert took.edges_s == tuple(10.0 + bar for bar in range(31))
    assert took.passed == (3, *(0,) * 29)
    assert took.others == (*(0,) * 29, 1)
    for each, counts in ((rows[0], (1, 0)), (row("key_bend", 0, "failed"), (0, 1))):
        alone = result(each).cells[0].took
        assert alone is not None
        assert (alone.passed[0], alone.others[0]) == counts
        assert alone.edges_s[1] - alone.edges_s[0] == 1.0, "a bar needs a width"
    assert result().cells[0].took is None


def test_the_success_against_what_was_drawn_has_an_interval_for_each_part() -> None:
    drawn = [("passed", -0.02), ("failed", -0.0161), ("passed", -0.0159), ("passed", 0.02)]
    rows = [
        row("key_bend", n, what)._replace(drawn={"start_m": x}) for n, (what, x) in enumerate(drawn)
    ]

    (found,) = result(*rows).cells[0].factors

    assert (found.name, found.unit) == ("start_m", "m")
    assert found.edges == pytest.approx([-0.02 + 0.004 * part for part in range(11)])
    assert (found.runs, found.passed) == ((2, 1, *(0,) * 7, 1), (1, 1, *(0,) * 7, 1))
    assert found.least[:2] == (wilson(1, 2, 0.95).least, wilson(1, 1, 0.95).least)
    assert found.most[:2] == (wilson(1, 2, 0.95).most, 1.0)
