"""Missions on the backend physics: they end as they do in the kinematic simulator."""

from __future__ import annotations

from pathlib import Path
from statistics import mean

import pytest

import pirate_sm
from benchmarks.campaign import run
from pirate_sm.api import Run
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.physics import chain_of

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
@pytest.mark.parametrize("quick", [True, False])
def test_a_round_pipe_is_driven_in_space_and_in_its_plane_alike(
    assumed_speeds: str, quick: bool
) -> None:
    """Its clamps close sooner: on the floor walls are nearer to each other than a diameter."""
    twin = assumed_speeds if quick else None
    plane, space, flat = (
        pirate_sm.run("exp_1_round", backend=backend, pipe=pipe, twin=twin)
        for backend, pipe in (
            ("physics", "straight_113"),
            ("physics", "straight_113_round"),
            ("sim", "straight_113_round"),
        )
    )

    assert space.outcome == plane.outcome == flat.outcome == "succeeded"
    assert driven_s(space) == pytest.approx(driven_s(plane), rel=0.05)
    assert clamped_s(space) < clamped_s(plane)
    if quick:  # less of the time is that of clamping
        assert space.duration_s == pytest.approx(plane.duration_s, rel=0.05)
    # Forces of clamps that close from loose differ, and with them when the last joint stands.
    assert clamped_s(space) == pytest.approx(clamped_s(flat), abs=winding_s(quick))
    assert way_m(space) == pytest.approx(way_m(plane), abs=0.03)


def winding_s(quick: bool) -> float:
    """Return the time constant by which a motor winds its joint's spring up."""
    joint = chain_of(load_robot(library.robots()[0]).profile).joints[1]
    rate_rad_s = 1.0 if quick else joint.rate_rad_s
    return joint.stall_nm / (rate_rad_s * joint.stiffness_nm_rad)


def clamped_s(run: Run) -> float:
    """Return when both parts have clamped."""
    phases = run.table("phases")
    return float(phases["time_s"][phases["phase"].index("forth")])


def driven_s(run: Run) -> float:
    """Return how long the way up and down has taken."""
    return run.duration_s - clamped_s(run)


def way_m(run: Run) -> float:
    """Return how far the robot is from where it began, in truth."""
    poses = run.poses()
    assert poses is not None
    assert poses.true
    began, ended = (mean(x for x, *_ in poses.points[at]) for at in (0, -1))
    return ended - began


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
