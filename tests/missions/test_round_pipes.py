"""Missions in round pipes: the robot passes in space what round pipes are made of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.campaign import run
from benchmarks.space import BEND, DEEPEST_M, DRIVE, ROWS, Row, failure, order_of, pipe_of
from pirate_sm.wiring import Order

PASSED = (
    *("mitre", "mitre, tilted up", "tee, in", "tee, in, down", "tee, in 110 mm"),
    *("mitre of 45 deg", "mitre of 75 deg, climbing", "elbow of 45 deg, 300 mm"),
    *("mitre, up", "tee, in, up", "two planes, up", "house"),
    *("tee, on, square", "120 to 105 mm", "110 to 120 mm", "step to 110 mm", "step to 120 mm"),
)


@pytest.mark.parametrize(
    "row", [row for row in ROWS if row.name in PASSED], ids=lambda row: row.name
)
def test_it_passes(row: Row, tmp_path: Path) -> None:
    outcome = run(order_of(row.mission, row.pipe or str(pipe_of(row, tmp_path)), 1))
    assert failure(outcome, row) == ""
    assert 0.0 < outcome.deepest_m < DEEPEST_M


@pytest.mark.parametrize(("seed", "fault"), [(0, "robot.stuck"), (2, "clamp.lost")])
def test_a_mouth_in_the_plane_of_a_clamped_part_is_not_passed_and_it_is_said(
    tmp_path: Path, seed: int, fault: str
) -> None:
    # A part opens into the mouth, or catches in it while wheels of the other part slip.
    row = next(row for row in ROWS if row.name == "tee, on, in plane")
    assert row.mission == DRIVE
    varied = {"start_jitter_m": 0.02, "friction_jitter": 0.20, "diameter_jitter_m": 0.002}
    order = order_of(row.mission, str(pipe_of(row, tmp_path)), seed)
    outcome = run(replace(order, **varied))
    assert outcome.outcome == "failed"
    assert fault in outcome.message


def test_a_bend_square_to_the_robot_is_not_passed_and_nothing_breaks(tmp_path: Path) -> None:
    row = Row("square", "{straight: 1 m}, {mitre: 90 deg, roll: 90 deg}, {straight: 1 m}")
    path = tmp_path / "square.yaml"
    path.write_text(
        "format: 1\npipe: square\nsection: round\ndiameter: 120 mm\n"
        f"segments: [{row.segments}]\nstart: {{at: 700 mm}}\n",
        encoding="utf-8",
    )
    outcome = run(Order(BEND, "sim", pipe=str(path), seed=1))
    assert outcome.outcome != "succeeded"
    assert not outcome.gone
    assert outcome.deepest_m < DEEPEST_M
