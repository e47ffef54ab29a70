"""A cell's counts and its end do not depend on the order in which results come."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule
from pirate_sm.lab.campaign.tally import Tally

from .rows import cell, row

ALL = StoppingRule()


def tally(stop: StoppingRule = ALL, **wanted: object) -> Tally:
    return Tally(cell(**wanted), 0.95, stop)  # type: ignore[arg-type]


@given(
    verdicts=st.lists(st.sampled_from(["passed"] * 6 + ["failed", "false"]), min_size=1),
    half_width=st.floats(0.05, 0.45),
    violated=st.booleans(),
    order=st.integers(0, 10**6),
    size=st.integers(1, 9),
)
def test_the_stopping_rule_does_not_depend_on_who_was_faster(
    verdicts: list[str], half_width: float, violated: bool, order: int, size: int
) -> None:
    stop = StoppingRule(half_width=half_width, violated=violated)
    wanted = {"seeds": range(len(verdicts)), "expect": Expectation(success=0.8)}
    rows = [row("key_bend", seed, verdict) for seed, verdict in enumerate(verdicts)]
    in_turn, hasty = tally(stop, **wanted), tally(stop, **wanted)
    for each in rows:
        in_turn.add([each])
    chunks = [rows[n : n + size] for n in range(0, len(rows), size)]
    Random(order).shuffle(chunks)
    for chunk in chunks:
        hasty.add(chunk)

    assert replace(hasty) == replace(in_turn)
    assert hasty.decided
    assert hasty.missed() == in_turn.missed()


def test_results_before_a_gap_alone_count() -> None:
    counted = tally(seeds=range(10))
    counted.add([row("key_bend", seed) for seed in (0, 1, 3, 4)])
    assert counted.runs == 2
    counted.add([row("key_bend", 2)])
    assert counted.runs == 5


def test_a_result_that_comes_twice_counts_once() -> None:
    counted = tally(seeds=range(10))
    counted.add([row("key_bend", 0), row("key_bend", 0, "failed"), row("key_bend", 99)])
    counted.add([row("key_bend", 0, "failed")])
    assert (counted.runs, counted.passed, counted.without_result) == (1, 1, 9)


def test_seeds_of_a_list_are_counted_in_its_order() -> None:
    counted = tally(seeds=(30, 7, 12))
    counted.add([row("key_bend", 7, "failed"), row("key_bend", 12)])
    assert counted.runs == 0
    counted.add([row("key_bend", 30)])
    assert counted.passes == bytes([1, 0, 1])
    assert counted.decided


def test_a_narrow_interval_ends_a_cell() -> None:
    counted = tally(StoppingRule(half_width=0.01), seeds=range(1000))
    counted.add(row("key_bend", seed) for seed in range(1000))
    assert counted.decided
    assert counted.interval.half_width <= 0.01
    assert tally_of(counted.runs - 1).interval.half_width > 0.01


def test_an_interval_as_narrow_as_asked_is_narrow_enough() -> None:
    limit = tally_of(50).interval.half_width
    counted = tally(StoppingRule(half_width=limit), seeds=range(1000))
    counted.add(row("key_bend", seed) for seed in range(1000))
    assert counted.runs == 50


def test_a_cause_keeps_its_first_hundred_seeds() -> None:
    counted = tally(seeds=range(130))
    counted.add(row("key_bend", seed, "failed") for seed in range(130))
    (cause,) = counted.causes.values()
    assert (cause.count, cause.seeds) == (130, list(range(100)))


def tally_of(runs: int) -> Tally:
    counted = tally(seeds=range(1000))
    counted.add(row("key_bend", seed) for seed in range(runs))
    return counted


def test_a_cell_ends_when_it_can_no_longer_be_as_expected() -> None:
    expect = Expectation(success=0.97)
    counted = tally(StoppingRule(violated=True), seeds=range(100), expect=expect)
    counted.add(
        row("key_bend", seed, "failed" if seed % 10 == 5 else "passed") for seed in range(100)
    )
    # The fourth failure of a hundred, that of seed 35, is one too many for 97 %.
    assert (counted.runs, counted.missed()) == (36, ("success",))


@pytest.mark.parametrize(
    ("share", "failed", "runs", "missed"),
    [
        (0.97, 3, 100, ()),
        (0.97, 4, 100, ("success",)),
        (0.07, 93, 100, ()),  # 0.07 times 100 is a little more than 7
        (0.5, 2, 3, ("success",)),
        (0.5, 1, 2, ()),
    ],
)
def test_exactly_the_expected_share_is_enough(
    share: float, failed: int, runs: int, missed: tuple[str, ...]
) -> None:
    counted = tally(seeds=range(runs), expect=Expectation(success=share))
    verdicts = ["failed"] * failed + ["passed"] * (runs - failed)
    counted.add(row("key_bend", seed, verdict) for seed, verdict in enumerate(verdicts))
    assert counted.decided
    assert counted.missed() == missed


def test_the_seeds_without_a_result_are_those_that_have_not_come() -> None:
    counted = tally(seeds=range(10, 18))
    counted.add([row("key_bend", seed) for seed in (10, 11, 13, 16)])

    assert counted.runs == 2
    assert list(counted.missing(0)) == [2, 4, 5, 7]
    assert list(counted.missing(5)) == [5, 7]
    assert counted.without_result == 4
    counted.add([row("key_bend", seed) for seed in range(10, 18)])
    assert list(counted.missing(0)) == []
    assert counted.without_result == 0


def test_a_false_success_is_missed_unless_it_is_allowed() -> None:
    rows = [row("key_bend", 0, "false", "said to have succeeded")]
    strict = tally(seeds=range(1))
    strict.add(rows)
    lenient = tally(seeds=range(1), expect=Expectation(truthful=0.0))
    lenient.add(rows)
    assert (strict.missed(), lenient.missed()) == (("truthful",), ())


def test_a_run_that_broke_safety_is_missed_although_it_passed() -> None:
    rows = [row("key_bend", 0), row("key_bend", 1, unsafe="a wheel turns at the end")]
    strict = tally(seeds=range(2), expect=Expectation(safe=1.0))
    strict.add(rows)
    half = tally(seeds=range(2), expect=Expectation(safe=0.5))
    half.add(rows)
    assert (strict.passed, strict.unsafe) == (2, 1)
    assert (strict.missed(), half.missed()) == (("safe",), ())
    (cause,) = strict.unsafe_causes.values()
    assert (cause.verdict, cause.why) == ("unsafe", "a wheel turns at the end")
    assert (cause.count, cause.seeds) == (1, [1])


def test_a_run_that_holds_counts_for_holding_alone() -> None:
    counted = tally(seeds=range(2), expect=Expectation(success=0.5, holding=1.0))
    held = row("key_bend", 1, "failed")._replace(held=True)
    counted.add([row("key_bend", 0), held])
    assert (counted.passed, counted.held, counted.missed()) == (1, 2, ())
    lost = tally(seeds=range(2), expect=Expectation(success=0.5, holding=1.0))
    lost.add([row("key_bend", 0), row("key_bend", 1, "failed")])
    assert lost.missed() == ("holding",)


def test_the_worst_of_all_runs_is_kept() -> None:
    counted = tally(seeds=range(4))
    counted.add(
        [
            row("key_bend", 0, short_m=0.004, deepest_m=0.001),
            row("key_bend", 1, short_m=0.011, deepest_m=0.003),
            row("key_bend", 2, short_m=0.002, deepest_m=0.002),
            row("key_bend", 3, "failed", short_m=0.9),
        ]
    )
    assert counted.farthest_short_m == 0.011
    assert counted.deepest_m == 0.003


def test_causes_that_differ_in_what_was_measured_alone_are_one() -> None:
    counted = tally(seeds=range(3))
    counted.add(
        [
            row("key_bend", 0, "failed", "gamma_2 has shown the same for 1.6 s"),
            row("key_bend", 1, "failed", "gamma_2 has shown the same for 12 s"),
            row("key_bend", 2, "failed", "gamma_3 has shown the same for 1.6 s"),
        ]
    )
    assert [(each.count, each.seeds) for each in counted.causes.values()] == [(2, [0, 1]), (1, [2])]


def test_a_cause_is_the_sentence_of_its_first_run_with_its_numbers() -> None:
    counted = tally(seeds=(7, 3, 5))
    counted.add(
        [
            row("key_bend", 3, "failed", "120 mm are too wide: gamma_2 showed 1.6 s"),
            row("key_bend", 7, "failed", "120 mm are too wide: gamma_2 showed 12 s"),
            row("key_bend", 5, "failed", "120 mm are too narrow"),
        ]
    )
    assert [(each.why, each.varies) for each in counted.causes.values()] == [
        ("120 mm are too wide: gamma_2 showed 12 s", True),
        ("120 mm are too narrow", False),
    ]


def test_runs_that_come_before_an_earlier_one_are_done_though_they_do_not_count_yet() -> None:
    counted = tally(seeds=range(10))
    counted.add([row("key_bend", 3), row("key_bend", 4)])
    assert (counted.runs, counted.done, counted.without_result) == (0, 2, 8)

    counted.add(row("key_bend", seed) for seed in range(3))
    assert (counted.runs, counted.done, counted.without_result) == (5, 5, 5)
