"""The search for the least failing change finds it where it is known in closed form."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import hypot
from pathlib import Path

import pytest

from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.falsify import (
    STARTS,
    Evaluation,
    Falsified,
    Point,
    falsify,
    is_wrong,
    sides_of,
    values_at,
)
from pirate_sm.lab.campaign.margins_model import MarginFactor
from pirate_sm.lab.campaign.plan import mark_of
from pirate_sm.lab.campaign.store import Store

from .rows import Hasty, cell, plan, row

pytest.importorskip("cmaes")

FACTORS = (
    MarginFactor("friction", "", 0.1, 0.9, 0.5),
    MarginFactor("tilt", "deg", 0.0, 0.5, 0.0),
    MarginFactor("noise.angle", "deg", 0.0, 0.1, 0.05),
    MarginFactor("messages_lost:share", "", 0.0, 0.5, 0.0),
)
SIDES = sides_of(FACTORS, 1.0)


def pushed(point: Point) -> float:
    """How far a change is beyond a plane: it fails above 0.6, by low friction and by tilt."""
    return -0.8 * point[0] + 0.6 * point[1]


def judged(point: Point) -> RunRow:
    verdict = "failed" if pushed(point) >= 0.6 else "false" if point[2] > 0.9 else "passed"
    return row(str(point), 0, verdict)._replace(near=max(pushed(point), 0.0) ** 4)


def searched(
    budget: int = 300, seed: int = 0, judged: Callable[[Point], RunRow] = judged
) -> tuple[Falsified, list[Point]]:
    asked: list[Point] = []

    def evaluate(points: Sequence[Point]) -> list[RunRow]:
        asked.extend(points)
        return [judged(each) for each in points]

    return falsify(SIDES, evaluate, budget, seed), asked


@pytest.mark.parametrize("seed", range(3))
def test_the_least_change_is_found_with_the_factors_that_it_needs(seed: int) -> None:
    least = searched(seed=seed)[0].least["failed"]

    assert hypot(*least.point) <= 0.6 * 1.3, "at 0.6 is the plane"
    assert least.point[2:] == (0.0, 0.0)
    assert pushed(least.point) >= 0.6


def test_a_change_stays_within_its_ranges_and_the_budget_is_kept() -> None:
    found, asked = searched(200)

    assert found.runs == len(set(asked)) <= 230
    assert all(low <= x <= high for p in asked for x, (low, high) in zip(p, SIDES, strict=True))
    assert found.wrong == sum(is_wrong(judged(each)) for each in set(asked))


def test_the_same_seed_asks_for_the_same_changes() -> None:
    assert searched(100, seed=4)[1] == searched(100, seed=4)[1]
    assert searched(100, seed=4)[1] != searched(100, seed=5)[1]


def test_a_false_success_is_kept_besides_a_failure() -> None:
    def both(point: Point) -> RunRow:
        return row(str(point), 0, "false" if point[1] > 0.2 else "failed" if point[0] else "passed")

    least = searched(judged=both)[0].least

    assert set(least) == {"failed", "false"}
    assert least["false"].point[0] == 0.0
    assert 0.2 < least["false"].point[1] < 0.25


def test_a_run_that_cannot_begin_is_no_failure() -> None:
    refused = row("a", 0, "failed")._replace(outcome="refused")

    assert not is_wrong(refused)
    assert not searched(60, judged=lambda point: refused)[0].least


def test_an_internal_error_is_found_as_a_kind_of_its_own() -> None:
    def broken(point: Point) -> RunRow:
        return row(str(point), 0, "bug" if point[1] > 0.2 else "passed", "ZeroDivisionError")

    found = searched(judged=broken)[0]

    assert set(found.least) == {"bug"}
    assert 0.2 < found.least["bug"].size < 0.25
    assert found.wrong > 0


@pytest.mark.parametrize("seed", [2**32 // STARTS, 2**32 - 1, 2**64])
def test_every_seed_that_a_run_can_have_begins_a_search(seed: int) -> None:
    found, asked = searched(20, seed=seed)

    assert found.runs == len(set(asked)) > 1


def test_runs_that_are_stored_are_not_run_again(tmp_path: Path) -> None:
    one = replace(cell("bend", (0,)), around=FACTORS)
    points = [(-0.5, 0.0, 0.0, 0.25), (0.0, 0.0, 0.0, 0.0), (0.0, 0.5, 0.0, 0.0)]

    def rows(crew: Hasty) -> list[RunRow]:
        store = Store(tmp_path)
        store.begin(mark_of(plan(one)))
        found = Evaluation(one, store, crew, 0)(points)
        store.close()
        return found

    def result(chunk: Chunk, seed: int) -> RunRow:
        assert chunk.near
        return row(chunk.cell, seed, "failed" if chunk.order.numbers else "passed")

    crew, idle = Hasty(0, result=result), Hasty(1)
    first = rows(crew)

    assert [each.verdict for each in first] == ["failed", "passed", "failed"]
    assert len(crew.given) == 3
    assert list(map(str, rows(idle))) == list(map(str, first))
    assert not idle.given


def test_the_values_of_a_change_are_those_of_its_factors() -> None:
    values = values_at(FACTORS, (-0.5, 0.0, 0.0, 0.25))

    assert {each.name: each.written(value) for each, value in values.items()} == {
        "friction": "0.3",
        "messages_lost:share": "0.125",
    }
