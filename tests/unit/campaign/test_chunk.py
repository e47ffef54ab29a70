"""What a worker does with a chunk."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from pirate_sm.campaign import chunk as chunks
from pirate_sm.campaign.campaign_file import read_campaign
from pirate_sm.campaign.chunk import Chunk, OtherVersionError, Sent, run_chunk
from pirate_sm.campaign.code_version import code_version
from pirate_sm.campaign.conductor import chunk_of
from pirate_sm.campaign.recorded_run import record_chunk
from pirate_sm.recording.read.reader import read_recording
from pirate_sm.wiring import Order

ENTER = Path(__file__).parents[3] / "sequences" / "enter_2d.yaml"

IMPORTED = """
import pickle, sys
from pirate_sm.campaign.chunk import run_chunk
chunk, sent, version = pickle.load(sys.stdin.buffer)
rows = run_chunk(chunk, sent, version)
assert rows[0].verdict == "passed", rows
needless = {"textual", "matplotlib", "pandas", "pyarrow", "cv2", "mujoco", "typer", "rich",
            "pirate_sm.cli", "pirate_sm.console", "pirate_sm.checking", "pirate_sm.report"}
print(*sorted(needless & {*sys.modules}))
"""


@cache
def enter() -> tuple[Chunk, Sent]:
    plan = read_campaign(ENTER, range(3), check=False)
    (cell,) = plan.cells
    return chunk_of(cell, cell.seeds), Sent(cell.mission, plan.missions[cell.mission])


def test_each_seed_has_a_row_and_the_same_one_each_time() -> None:
    chunk, sent = enter()
    rows = run_chunk(chunk, sent, code_version())

    assert [each.seed for each in rows] == [0, 1, 2]
    assert {(each.cell, each.verdict) for each in rows} == {(chunk.cell, "passed")}
    assert repr(run_chunk(chunk, sent, code_version())) == repr(rows)


def test_a_worker_with_other_code_refuses() -> None:
    with pytest.raises(OtherVersionError, match=code_version().replace("+", r"\+")):
        run_chunk(*enter(), "0.0.1+abc")


def test_an_exception_of_the_program_is_an_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    right = chunks.watched_run

    def breaks(order: Order, *args: object, **options: object) -> object:
        if order.seed == 1:
            raise ZeroDivisionError("by nothing")
        return right(order, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(chunks, "watched_run", breaks)
    rows = run_chunk(*enter(), code_version())

    assert [each.verdict for each in rows] == ["passed", "bug", "passed"]
    assert rows[1].why.startswith("ZeroDivisionError: by nothing (test_chunk.py:")


def test_a_run_that_cannot_be_begun_fails() -> None:
    chunk, sent = enter()
    wide = replace(chunk, order=replace(chunk.order, defects=("none_of_ours",)), seeds=(0,))
    (row,) = run_chunk(wide, sent, code_version())

    assert (row.outcome, row.verdict) == ("refused", "failed")
    assert row.why


def test_a_failed_run_is_recorded(tmp_path: Path) -> None:
    chunk, sent = enter()
    (recorded,) = record_chunk(replace(chunk, seeds=(2,)), sent, code_version())
    path = tmp_path / "run.mcap"
    path.write_bytes(recorded.content)

    assert read_recording(path).header.options["seed"] == 2


@pytest.mark.thorough
def test_a_worker_imports_no_more_than_it_needs() -> None:
    chunk, sent = enter()
    told = subprocess.run(
        [sys.executable, "-c", IMPORTED],
        input=pickle.dumps((chunk, sent, code_version())),
        capture_output=True,
        check=True,
    )
    assert told.stdout.split() == []
