"""Missions on the backend physics: they end as they do in the kinematic simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.campaign import run
from pirate_sm.running.wiring import Order

CROSSING_M = 1.0


@pytest.mark.thorough
@pytest.mark.parametrize("defects", [(), ("wheels_3_4_dead",)])
def test_the_bend_is_passed_in_about_the_same_time(defects: tuple[str, ...]) -> None:
    kinematic, physics = (
        run(Order("mitre_bend", backend, defects=defects)) for backend in ("sim", "physics")
    )

    assert physics.outcome == "succeeded"
    assert min(physics.arcs_m) > CROSSING_M
    assert list(physics.arcs_m) == sorted(physics.arcs_m, reverse=True)
    assert physics.states == kinematic.states
    assert physics.time_s == pytest.approx(kinematic.time_s, rel=0.05)


@pytest.mark.thorough
def test_a_round_pipe_is_driven_in_space_and_in_its_plane_alike() -> None:
    plane, space, flat = (
        run(Order("exp_1_round", backend, pipe=pipe))
        for backend, pipe in (
            ("physics", "straight_113"),
            ("physics", "straight_113_round"),
            ("sim", "straight_113_round"),
        )
    )

    assert space.outcome == plane.outcome == flat.outcome == "succeeded"
    assert space.time_s == pytest.approx(plane.time_s, rel=0.05)
    assert space.distance_m == pytest.approx(plane.distance_m, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("roll", "outcome", "message"),
    [
        ("-90 deg", "succeeded", "Both parts in the horizontal plane and driving"),
        ("0 deg", "failed", "Holding, both parts clamped, in a plane that is not horizontal"),
    ],
    ids=["upright", "lying"],
)
def test_both_parts_turn_by_a_quarter_in_a_round_pipe(
    tmp_path: Path, roll: str, outcome: str, message: str
) -> None:
    """In space the apex opens by up to 18 deg while the slack posture is taken."""
    pipe = tmp_path / "tube.yaml"
    pipe.write_text(
        f"format: 1\npipe: tube\ndiameter: 120 mm\nsection: round\nroll: {roll}\n"
        "segments: [{straight: 1.135 m}]\nstart: {at: 500 mm}\n"
    )

    entered = run(Order("enter_3d", "physics", pipe=str(pipe)))

    assert (entered.outcome, entered.message) == (outcome, message)
