"""Missions in round pipes: the robot passes in space what round pipes are made of."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from representative import thorough_but

from benchmarks.campaign import Outcome, run
from benchmarks.space import (
    BEND,
    CLIMBING,
    DEEPEST_M,
    DRIVE,
    ROWS,
    Row,
    failure,
    order_of,
    pipe_of,
)
from pirate_sm.running.wiring import Order

PASSED = (
    *("mitre", "mitre, tilted up", "tee, in", "tee, in, down", "tee, in 110 mm"),
    *("mitre of 45 deg", "mitre of 75 deg, climbing", "elbow of 45 deg, 300 mm"),
    *("mitre, up", "tee, in, up", "two planes, up", "house"),
    *("tee, on, square", "120 to 105 mm", "110 to 120 mm", "step to 110 mm", "step to 120 mm"),
)
FEW = ("mitre", "tee, in, down", "elbow of 45 deg, 300 mm", "step to 120 mm")


@pytest.mark.parametrize("name", thorough_but(FEW, PASSED))
def test_it_passes(name: str, tmp_path: Path) -> None:
    row = next(row for row in ROWS if row.name == name)
    outcome = run(order_of(row.mission, row.pipe or str(pipe_of(row, tmp_path)), 1))
    assert failure(outcome, row) == ""
    assert 0.0 < outcome.deepest_m < DEEPEST_M


@pytest.mark.parametrize(("seed", "fault"), [(0, "robot.stuck"), (4, "clamp.lost")])
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


STEP = next(row for row in ROWS if row.name == "step to 110 mm")
VARIED = {"start_jitter_m": 0.02, "friction_jitter": 0.20, "diameter_jitter_m": 0.002}


@pytest.mark.parametrize("seed", thorough_but([56], [56, 190]))
def test_a_robot_that_is_stuck_at_a_step_clamps_gently_and_drives_the_rest_of_its_way(
    tmp_path: Path, seed: int
) -> None:
    # Pipes of 121.9 mm: with its usual clamp the robot presses wheel 2 on the edge and stalls.
    order = replace(order_of(DRIVE, str(pipe_of(STEP, tmp_path)), seed), **VARIED)
    outcome = run(order)
    assert outcome.faults == ("robot.stuck (stuck)",)
    assert failure(outcome, STEP) == ""
    assert outcome.distance_m == pytest.approx(1.0, abs=0.05)
    assert all(abs(torque) > 0.5 for torque in outcome.torques[1:5])
    assert 0.0 < outcome.deepest_m < DEEPEST_M


def over_the_step_upright(tmp_path: Path, seed: int, friction: float, twin: str = "") -> Outcome:
    pipe = pipe_of(STEP, tmp_path)
    walls = f"frame: {CLIMBING}\nfriction: {{static: {friction}, kinetic: {0.7 * friction:g}}}"
    text = pipe.read_text(encoding="utf-8").replace("frame: {}", walls)
    pipe.write_text(text, encoding="utf-8")
    outcome = run(replace(order_of(DRIVE, str(pipe), seed), **VARIED, twin=twin or None))
    assert outcome.slid_m < 0.001
    assert not [each for each in outcome.faults if each.startswith("robot.fallen")]
    assert outcome.deepest_m < DEEPEST_M
    return outcome


@pytest.mark.parametrize(
    ("seed", "friction"), thorough_but([(2, 0.7)], [(0, 0.5), (2, 0.7), (4, 0.5), (6, 0.5)])
)
def test_a_way_over_a_step_in_an_upright_pipe_is_as_long_as_it_is_said_to_be(
    tmp_path: Path, seed: int, friction: float
) -> None:
    outcome = over_the_step_upright(tmp_path, seed, friction)
    assert outcome.outcome == "succeeded"
    said_m, bound_m = (float(each) / 1000.0 for each in outcome.message.split()[:3:2])
    assert abs(outcome.distance_m - said_m) < bound_m < 0.15
    assert outcome.distance_m == pytest.approx(said_m, abs=0.02)


@pytest.mark.parametrize(
    ("seed", "friction", "end"),
    thorough_but(
        [(2, 0.7, "fault")],
        [(0, 0.5, "succeeded"), (2, 0.7, "fault"), (4, 0.5, "fault"), (6, 0.5, "fault")],
    ),
)
def test_belief_in_a_way_over_a_step_in_an_upright_pipe_ends_where_wheels_slipped(
    tmp_path: Path, assumed_speeds: str, seed: int, friction: float, end: str
) -> None:
    # Some stick on the edge for seconds while wheels of the other part turn: 0.7 m for 1 m.
    outcome = over_the_step_upright(tmp_path, seed, friction, assumed_speeds)
    assert outcome.outcome == end
    if end == "succeeded":
        assert outcome.distance_m == pytest.approx(1.0, abs=0.02)
    else:
        assert "distance.unknown" in outcome.message
        assert all(abs(torque) > 0.2 for torque in outcome.torques[1:5])  # both parts hold


@pytest.mark.thorough
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
