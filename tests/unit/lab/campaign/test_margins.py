"""The margins of a cell are the same however its runs come back, and after a client was killed."""

from __future__ import annotations

import json
from dataclasses import replace
from math import exp
from pathlib import Path
from random import Random

import pytest
from late import late

from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import Conductor, stored
from pirate_sm.lab.campaign.margins_model import MarginBound, MarginFactor, Margins
from pirate_sm.lab.campaign.page import page_of
from pirate_sm.lab.campaign.plan import CampaignPlan, mark_of
from pirate_sm.lab.campaign.results import CampaignResult, as_text, result_of
from pirate_sm.lab.campaign.store import Store

from .rows import Hasty, cell, plan, row

parquet = late("pyarrow.parquet")

FRICTION = MarginFactor("friction", "", 0.1, 0.9, 0.5)
DIAMETER = MarginFactor("diameter", "mm", 0.11, 0.13, 0.12)
USUAL = Margins(pairs=(("friction", "diameter"),), runs=60)


def around(margins: Margins = USUAL) -> CampaignPlan:
    one = replace(cell("bend", range(margins.runs)), around=(FRICTION, DIAMETER))
    return replace(plan(one), margins=margins)


def drawn(chunk: Chunk, seed: int) -> RunRow:
    """Fail below a friction of 0.3, sharply, and above a diameter of 125 mm."""
    numbers = chunk.order.numbers
    friction = float(numbers.get("pipe.friction", "0.5"))
    wide = float(numbers.get("pipe.diameter", "120mm").removesuffix("mm")) > 125.0
    likely = 0.0 if wide else 1.0 / (1.0 + exp(-80.0 * (friction - 0.3)))
    passes = Random(f"{chunk.cell} {seed}").random() < likely
    return row(chunk.cell, seed, "passed" if passes else "failed", "it slips")


def found(plan: CampaignPlan, folder: Path, crew: Hasty) -> CampaignResult:
    store = Store(folder)
    store.begin(mark_of(plan))
    conductor = Conductor(plan, store)
    conductor.conduct(crew)
    store.close()
    return result_of(plan, conductor.results, folder, conductor.margins)


def text(plan: CampaignPlan, folder: Path, crew: Hasty) -> str:
    return as_text(found(plan, folder, crew)).replace(str(folder), "FOLDER")


def test_the_margins_of_each_factor_are_found(tmp_path: Path) -> None:
    (only,) = found(around(), tmp_path, Hasty(0, result=drawn)).cells
    friction, diameter = only.margins

    assert 0.3 < friction.holds_from < 0.4
    assert friction.holds_to == friction.high == 0.9
    assert friction.fails_below in (0.2, 0.3)
    assert (diameter.holds_from, diameter.holds_to) == (110, 125)
    assert "all above tried holds" in friction.words
    (pair,) = only.maps
    assert len(pair.levels) == 49
    assert {each.verdict for each in pair.levels} >= {"holds", "fails"}
    assert not only.incomplete


@pytest.mark.parametrize("seed", range(4))
def test_they_are_the_same_for_any_order_and_any_number_of_workers(
    tmp_path: Path, seed: int
) -> None:
    alone = text(around(), tmp_path / "alone", Hasty(0, room=1, result=drawn))

    assert text(around(), tmp_path / "many", Hasty(seed, 3 + 4 * seed, drawn)) == alone


class KilledError(Exception):
    pass


def test_a_client_that_was_killed_continues_with_what_is_stored(tmp_path: Path) -> None:
    whole = text(around(), tmp_path / "whole", Hasty(1, result=drawn))
    crew, folder = Hasty(2), tmp_path / "killed"

    def dies(chunk: Chunk, seed: int) -> RunRow:
        if len(crew.given) > 400:
            raise KilledError
        return drawn(chunk, seed)

    crew.result = dies
    store = Store(folder, clock=iter(range(0, 10**6, 10)).__next__)  # writes every chunk
    store.begin(mark_of(around()))
    with pytest.raises(KilledError):
        Conductor(around(), store).conduct(crew)
    store.close()
    half = stored(folder)
    (only,) = result_of(half.plan, half.tallies, folder, half.margins).cells
    assert "values of its factors have no result yet" in only.incomplete
    again = Hasty(3, result=drawn)

    assert text(around(), folder, again) == whole
    assert again.given
    idle = Hasty(4, result=drawn)
    assert text(around(), folder, idle) == whole
    assert not idle.given


def test_wanted_margins_that_are_missed_are_named_and_others_are_not(tmp_path: Path) -> None:
    expects = {
        "friction": (MarginBound(">=", "0.4"), MarginBound("<=", "0.9")),
        "diameter": (MarginBound("<=", "128 mm"),),
    }
    result = found(around(Margins(expects=expects, runs=60)), tmp_path, Hasty(0, result=drawn))

    assert result.cells[0].missed == ("margin of diameter <= 128 mm",)
    assert not result.good
    assert "MISSED: <= 128 mm" in as_text(result)


def test_a_cell_that_does_not_hold_itself_has_no_margins(tmp_path: Path) -> None:
    crew = Hasty(0, result=lambda chunk, seed: row(chunk.cell, seed, "failed"))
    (only,) = found(around(), tmp_path, crew).cells

    assert [each.words for each in only.margins] == ["does not hold"] * 2
    assert len(crew.given) <= 40


def test_results_say_how_they_were_changed_and_the_page_draws_them(tmp_path: Path) -> None:
    result = found(around(), tmp_path, Hasty(0, result=drawn))
    names = parquet.read_table(tmp_path / "results").column("name").to_pylist()
    page = page_of(result, "recordings")

    assert "bend: friction 0.3" in names
    assert 'class="margins"' in page
    assert 'class="zone fails"' in page
    assert "it slips" in page
    assert json.dumps(result.as_data())
