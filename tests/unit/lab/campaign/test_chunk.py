"""What a worker does with a chunk."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import replace
from functools import cache
from itertools import count
from pathlib import Path
from typing import cast

import pytest

from pirate_sm.lab.campaign import chunk as chunks
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.chunk import (
    Chunk,
    OtherVersionError,
    Sent,
    loaded_mission,
    run_chunk,
    sampled_factors,
)
from pirate_sm.lab.campaign.conductor import chunk_of, record_chunk
from pirate_sm.lab.campaign.plan import code_version
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.wiring import Order, Prepared, prepare
from pirate_sm.simulation.simulated_robot import FullTruth

ENTER = Path(__file__).parents[4] / "sequences" / "enter_2d.yaml"

IMPORTED = """
import pickle, sys
from pirate_sm.lab.campaign.chunk import run_chunk
chunk, sent, version = pickle.load(sys.stdin.buffer)
rows = run_chunk(chunk, sent, version)
assert rows[0].verdict == "passed", rows
needless = {"textual", "matplotlib", "pandas", "pyarrow", "cv2", "mujoco", "typer", "rich",
            "pirate_sm.checking", "pirate_sm.cli", "pirate_sm.views.console",
            "pirate_sm.views.report"}
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


def test_a_row_has_what_its_run_drew() -> None:
    chunk, sent = enter()
    order = replace(
        chunk.order,
        start_jitter_m=0.02,
        friction_jitter=0.2,
        defects=("gamma_2_stiff:friction=0.1Nm..0.3Nm,after=5s",),
    )
    loaded = loaded_mission(sent)
    rows = run_chunk(replace(chunk, order=order), sent, code_version())

    for each in rows:
        exact, drew = (
            prepare(replace(order, seed=each.seed, start_jitter_m=most_m), loaded)
            for most_m in (0.0, 0.02)
        )
        start_m = _first_wheel_m(drew) - _first_wheel_m(exact)
        (defect,) = drew.order.defects
        friction = float(defect.partition("friction=")[2].partition("Nm")[0])
        assert {*each.drawn} == {"start_m", "friction", "gamma_2_stiff_friction"}
        assert each.drawn["start_m"] == pytest.approx(start_m)
        assert each.drawn["gamma_2_stiff_friction"] == pytest.approx(friction)
        assert -0.2 < each.drawn["friction"] < 0.2
    assert len({each.drawn["friction"] for each in rows}) == 3


def test_each_seed_takes_its_robot_from_the_sample_of_a_twin(tmp_path: Path) -> None:
    chunk, sent = enter()
    file = tmp_path / "twin.yaml"
    rows_of_robots = "[[0.8, 0.3], [0.9, 0.3]]"
    file.write_text(
        "format: 1\nrobot: pirate_ii\nsample:\n"
        f"  numbers: [bend no_load_speed, wheel hold_torque]\n  robots: {rows_of_robots}\n"
    )
    order = replace(chunk.order, twin=f"{file}#seed")

    rows = run_chunk(replace(chunk, order=order, seeds=(2, 3)), sent, code_version())

    assert [each.why for each in rows] == ["", ""]
    assert [each.drawn for each in rows] == [
        {"bend_no_load_speed": 0.8},
        {"bend_no_load_speed": 0.9},
    ]
    assert [(each.name, each.unit, each.low, each.high) for each in sampled_factors(order)] == [
        ("bend_no_load_speed", "rad/s", 0.8, 0.9)
    ]
    assert rows[0].time_s != rows[1].time_s
    assert prepare(replace(order, seed=3), loaded_mission(sent)).order.twin == f"{file}#3"


def _first_wheel_m(prepared: Prepared) -> float:
    assert prepared.truth is not None
    return cast("FullTruth", prepared.truth()).arcs_m[0]


def test_long_runs_are_given_back_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "monotonic", count(0.0, 40.0).__next__)

    assert [each.seed for each in run_chunk(*enter(), code_version())] == [0]


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
