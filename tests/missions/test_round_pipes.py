"""Missions in round pipes: the robot passes in space what round pipes are made of."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.campaign import run
from benchmarks.space import BEND, DEEPEST_M, DRIVE, ROWS, Row, failure, order_of, pipe_of
from pirate_sm.wiring import Order

PASSED = (
    *("mitre", "mitre, tilted up", "tee, in", "tee, in, down", "tee, in 110 mm"),
    *("tee, on, square", "120 to 105 mm", "110 to 120 mm", "step to 120 mm"),
)


@pytest.mark.parametrize(
    "row", [row for row in ROWS if row.name in PASSED], ids=lambda row: row.name
)
def test_it_passes(row: Row, tmp_path: Path) -> None:
    outcome = run(order_of(row.mission, str(pipe_of(row, tmp_path)), 1))
    assert failure(outcome, row) == ""
    assert 0.0 < outcome.deepest_m < DEEPEST_M


def test_a_mouth_in_the_plane_of_a_clamped_part_takes_its_wall_away(tmp_path: Path) -> None:
    row = next(row for row in ROWS if row.name == "tee, on, in plane")
    assert row.mission == DRIVE
    outcome = run(order_of(row.mission, str(pipe_of(row, tmp_path)), 2))
    assert "clamp.lost" in outcome.message


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
