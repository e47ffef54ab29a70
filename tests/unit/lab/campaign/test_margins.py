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
from pirate_sm.lab.campaign.margins_page import margins_markup
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


@pytest.mark.thorough
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

    assert [each.words for each in only.margins] == ["fails at the value of the files"] * 2
    assert len(crew.given) <= 40


def test_a_cell_that_does_not_hold_itself_is_not_as_expected(tmp_path: Path) -> None:
    crew = Hasty(0, result=lambda chunk, seed: row(chunk.cell, seed, "failed"))
    result = found(around(), tmp_path, crew)

    assert not result.good
    assert "success >= 90 % at the values of the files, where it fails" in as_text(result)


def test_a_cell_in_doubt_is_said_and_drawn_to_be_that_and_not_to_fail(tmp_path: Path) -> None:
    def nine_of_ten(chunk: Chunk, seed: int) -> RunRow:
        return row(chunk.cell, seed, "passed" if seed % 10 else "failed")

    result = found(around(), tmp_path, Hasty(0, result=nine_of_ten))
    (only,) = result.cells
    drawing = margins_markup(only.margins, only.maps)

    assert [each.words for each in only.margins] == ["is doubtful at the value of the files"] * 2
    assert 'class="doubtful"' in drawing
    assert 'class="zone' not in drawing
    assert not result.good


def test_internal_errors_at_other_values_are_counted_and_shown(tmp_path: Path) -> None:
    def breaks(chunk: Chunk, seed: int) -> RunRow:
        bug = seed == 2 and chunk.order.numbers == {"pipe.friction": "0.8"}
        return row(chunk.cell, seed, "bug" if bug else "passed", "KeyError: gamma")

    result = found(around(Margins(runs=200)), tmp_path, Hasty(0, result=breaks))

    assert result.cells[0].bugs == 1
    assert not result.good
    assert "at 0.8: bug: KeyError: gamma" in as_text(result)
    assert "1 not as expected" in result.summary


def refused(key: str, seed: int) -> RunRow:
    return row(key, seed, "failed", "it is too wide")._replace(outcome="refused")


def test_values_that_cannot_be_run_neither_hold_nor_fail(tmp_path: Path) -> None:
    def too_wide(chunk: Chunk, seed: int) -> RunRow:
        wide = float(chunk.order.numbers.get("pipe.diameter", "120mm").removesuffix("mm")) > 125.0
        return refused(chunk.cell, seed) if wide else row(chunk.cell, seed)

    result = found(around(), tmp_path, Hasty(0, result=too_wide))
    (only,) = result.cells
    diameter = only.margins[1]
    lines = as_text(result)

    assert diameter.fails_above is None
    assert 125 <= diameter.holds_to < diameter.refused_above <= 127.5
    assert f"cannot be run at {diameter.refused_above:g} mm" in diameter.words
    assert "all above" not in diameter.words
    assert f"at {diameter.refused_above:g}: refused: it is too wide" in lines
    drawing = margins_markup(only.margins, only.maps)
    assert 'class="zone refused"' in drawing
    assert result.good


def test_a_cell_that_cannot_be_run_is_not_as_expected(tmp_path: Path) -> None:
    crew = Hasty(0, result=lambda chunk, seed: refused(chunk.cell, seed))
    result = found(around(), tmp_path, crew)

    assert not result.good
    assert "where it cannot be run" in as_text(result)


STICKS = MarginFactor("gamma_2_sticks:after", "s", 0.0, 30.0, 30.0, added=True)


@pytest.mark.parametrize(
    ("fails", "words"),
    [
        ("0", "fails at 30 s, where it does least; MISSED: >= 30 s"),
        ("2", "holds from 0 to 30 s; all below tried holds"),
    ],
)
def test_the_end_at_which_a_defect_does_least_is_run_with_it(
    tmp_path: Path, fails: str, words: str
) -> None:
    def sticks(chunk: Chunk, seed: int) -> RunRow:
        bad = fails == "0" and any("sticks" in each for each in chunk.order.defects)
        return row(chunk.cell, seed, "failed" if bad else "passed", "it sticks")

    margins = Margins(runs=60, expects={STICKS.name: (MarginBound(">=", "30 s"),)})
    one = replace(cell("bend", range(60)), around=(STICKS,))
    result = found(replace(plan(one), margins=margins), tmp_path, Hasty(0, result=sticks))
    (only,) = result.cells[0].margins

    assert only.words == words
    assert ("at 30: failed: it sticks" in as_text(result)) == (fails == "0")
    assert result.good == (fails != "0")


def test_results_say_how_they_were_changed_and_the_page_draws_them(tmp_path: Path) -> None:
    result = found(around(), tmp_path, Hasty(0, result=drawn))
    names = parquet.read_table(tmp_path / "results").column("name").to_pylist()
    page = page_of(result, "recordings")

    assert "bend: friction 0.3" in names
    assert 'class="margins"' in page
    assert 'class="zone fails"' in page
    assert "it slips" in page
    assert json.dumps(result.as_data())


def test_what_is_wanted_is_read_again_as_it_is_stored() -> None:
    wanted = Margins.model_validate(
        {"factors": {"friction": "0.1..0.9", "tilt": "usual"}, "expects": {"friction": ">= 0.35"}}
    )

    assert Margins.model_validate(json.loads(wanted.model_dump_json())) == wanted
