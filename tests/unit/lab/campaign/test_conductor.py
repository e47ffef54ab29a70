"""A campaign's table is the same however its chunks come back, and after the client was killed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.campaign.campaign_model import Expectation, StoppingRule
from pirate_sm.lab.campaign.chunk import Chunk, RunRow
from pirate_sm.lab.campaign.conductor import Conductor, Progress, stored
from pirate_sm.lab.campaign.plan import CampaignPlan, mark_of
from pirate_sm.lab.campaign.results import as_text, result_of
from pirate_sm.lab.campaign.store import DamagedMarkError, Store

from .rows import Hasty, cell, plan, row

TWO = plan(cell("a", range(95)), cell("b", range(200)), stop=StoppingRule(half_width=0.06))


def table(plan: CampaignPlan, folder: Path, crew: Hasty) -> str:
    store = Store(folder)
    store.begin(mark_of(plan))
    conductor = Conductor(plan, store)
    conductor.conduct(crew)
    store.close()
    return as_text(result_of(plan, conductor.results, folder)).replace(str(folder), "FOLDER")


@pytest.mark.parametrize("seed", range(5))
def test_the_table_is_the_same_for_any_order_and_any_number_of_workers(
    tmp_path: Path, seed: int
) -> None:
    alone = table(TWO, tmp_path / "alone", Hasty(0, room=1))

    assert table(TWO, tmp_path / "many", Hasty(seed, room=3 + 4 * seed)) == alone


def test_what_a_chunk_comes_back_without_is_run_too_and_each_run_is_counted(
    tmp_path: Path,
) -> None:
    whole = table(TWO, tmp_path / "whole", Hasty(1))
    store, shown = Store(tmp_path / "slow"), list[int]()
    store.begin(mark_of(TWO))
    conductor = Conductor(TWO, store)
    conductor.conduct(Hasty(2, room=2, each=1), lambda progress: shown.append(progress.done))
    store.close()

    text = as_text(result_of(TWO, conductor.results, tmp_path / "slow"))
    assert text.replace(str(tmp_path / "slow"), "FOLDER") == whole
    assert shown[:5] == [1, 2, 3, 4, 5]


class KilledError(Exception):
    pass


def test_a_client_that_was_killed_goes_on_with_what_is_stored(tmp_path: Path) -> None:
    whole = table(TWO, tmp_path / "whole", Hasty(1))
    crew, folder = Hasty(2), tmp_path / "killed"

    def dies(chunk: Chunk, seed: int) -> RunRow:
        if len(crew.given) > 240:
            raise KilledError
        return Hasty(0).result(chunk, seed)

    crew.result = dies
    store = Store(folder, clock=iter(range(0, 10**6, 10)).__next__)  # writes every chunk
    store.begin(mark_of(TWO))
    with pytest.raises(KilledError):
        Conductor(TWO, store).conduct(crew)
    store.close()
    stored = list(store.read())
    again = Hasty(3)

    assert table(TWO, folder, again) == whole
    assert {each.seed for rows in stored for each in rows if each.cell == "key_b"}
    assert len(again.given) < 295 - 60
    assert table(TWO, folder, Hasty(4)) == whole


def test_what_is_stored_is_not_run_again(tmp_path: Path) -> None:
    whole = table(TWO, tmp_path, Hasty(1))
    crew = Hasty(2)

    assert table(TWO, tmp_path, crew) == whole
    assert crew.given == []


def test_more_seeds_of_the_same_campaign_are_added(tmp_path: Path) -> None:
    table(plan(cell("a", range(50))), tmp_path, Hasty(1))
    crew = Hasty(2)
    table(plan(cell("a", range(70))), tmp_path, crew)

    assert sorted(crew.given) == [*range(50, 70)]


def test_a_campaign_ends_with_the_first_cell_that_is_not_as_expected(tmp_path: Path) -> None:
    strict = Expectation(success=0.99)
    wanted = plan(
        cell("a", range(60)),
        cell("b", range(200), strict),
        cell("c", range(200), strict),
        stop=StoppingRule(violated=True),
    )
    tables = {table(wanted, tmp_path / str(seed), Hasty(seed)) for seed in range(4)}

    assert len(tables) == 1
    (text,) = tables
    assert "c: not run, a cell before it is not as expected" in text
    assert "BELOW EXPECTED: success" in text


def test_results_are_read_without_the_campaigns_files(tmp_path: Path) -> None:
    text = table(TWO, tmp_path, Hasty(1))
    read, tallies, damaged, _ = stored(tmp_path)

    assert not damaged
    assert as_text(result_of(read, tallies, tmp_path)).replace(str(tmp_path), "FOLDER") == text


def test_results_of_something_else_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there are no results of a campaign"):
        stored(tmp_path)
    (tmp_path / "campaign.json").write_text('{"format": 7}')
    with pytest.raises(UsageError, match="have format 7, and this version reads 1"):
        stored(tmp_path)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("format", None, "`format` is missing"),
        ("cells", None, "`cells` is missing"),
        ("cells", 5, "`cells`: Input should be a valid array"),
        ("cells", [{"row": []}], "`cells.0.row`: Input should be a valid string"),
        ("confidence", "much", "`confidence`: Input should be a valid number"),
        ("stop", {"halfwidth": 0.1}, "`stop.halfwidth`: Extra inputs are not permitted"),
    ],
)
def test_a_damaged_description_is_named_with_what_is_wrong_and_what_to_do(
    tmp_path: Path, key: str, value: object, said: str
) -> None:
    table(TWO, tmp_path, Hasty(1))
    mark = {**mark_of(TWO), key: value}
    if value is None:
        del mark[key]
    (tmp_path / "campaign.json").write_text(json.dumps(mark), "utf-8")

    with pytest.raises(DamagedMarkError, match="rewrites it, and keeps the results") as caught:
        stored(tmp_path)
    assert f"campaign.json' is damaged ({said}" in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"[]", b"\xff", b"[" * 100_000, b'{"format": 1,'])
def test_a_description_that_is_no_json_object_is_damaged(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "campaign.json").write_bytes(content)

    with pytest.raises(DamagedMarkError, match=r"campaign.json' is damaged"):
        stored(tmp_path)


def test_a_bug_is_an_outcome_with_its_seed_and_a_command(tmp_path: Path) -> None:
    def breaks(chunk: Chunk, seed: int) -> RunRow:
        return row(chunk.cell, seed, "bug" if seed == 13 else "passed", "TypeError: no")

    text = table(plan(cell("a", range(30))), tmp_path, Hasty(1, result=breaks))

    assert "1 × bug: TypeError: no (seeds 13)" in text
    assert "pirate run mitre_bend --seed 13" in text


@pytest.mark.parametrize(
    ("done", "words"),
    [
        (40, " (40 of 2,000 runs, none new yet)"),
        (41, " (41 of 2,000 runs, 120 per hour)"),
    ],
)
def test_the_pace_is_that_of_the_runs_of_this_process_once_there_are_any(
    done: int, words: str
) -> None:
    assert Progress(done, 2_000).words(40, 30.0) == words
