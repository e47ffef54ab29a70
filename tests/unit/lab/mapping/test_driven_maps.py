"""Maps of simulated runs beside the pipes that were driven."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest
from representative import thorough_but

from benchmarks.maps import NEAR_DEG, NEAR_M, ROWS, Missed, Row, missed_in
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S
from pirate_sm.simulation.physics import chain_of

SEEDS = range(3)
"""Each has its own start, friction, diameter, noise, and errors of the detector's words."""


def row(name: str) -> Row:
    return next(each for each in ROWS if each.name == name)


def near(found: Missed, metres: float, degrees: float) -> None:
    assert found.notes == ()
    assert found.lengths_m == pytest.approx([0.0] * len(found.lengths_m), abs=metres)
    assert found.angles_deg == pytest.approx([0.0] * len(found.angles_deg), abs=degrees)
    assert found.rolls_deg == pytest.approx([0.0] * len(found.rolls_deg), abs=degrees)


def between_words_m() -> float:
    """Return how far a straight between two words may be off, m.

    Each word has an error of its own, of which three standard deviations count; and it begins up to
    one look late, in which a robot drives on at the full speed of its wheels.
    """
    profile = load_robot(library.robots()[0]).profile
    chain = chain_of(profile)
    speed_m_s = max(wheel.rate_rad_s for wheel in chain.wheels) * chain.wheel_radius_m
    return 3.0 * sqrt(2.0) * profile.simulation.noise.detector + speed_m_s * LOOK_EVERY_S


@pytest.mark.thorough
@pytest.mark.parametrize("seed", thorough_but({SEEDS[0]}, SEEDS))
@pytest.mark.parametrize("mission", ["house_connection", "house_connection_back"])
def test_the_map_of_a_house_connection_equals_its_file(mission: str, seed: int) -> None:
    found = missed_in(row(mission), seed)
    assert len(found.lengths_m) == 4  # main, riser before and behind its reducer, the leg behind
    near(found, between_words_m(), NEAR_DEG)
    assert found.radii_m == pytest.approx([0.0], abs=NEAR_M)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("mission", ["house_connection", "house_connection_back"])
def test_with_a_detector_that_is_never_off_it_equals_its_file_within_the_bar(
    tmp_path: Path, mission: str, seed: int
) -> None:
    exact = tmp_path / "exact.yaml"
    exact.write_text("format: 1\nrobot: pirate_ii\nnoise: {detector: 0 mm}\n", "utf-8")
    found = missed_in(row(mission), seed, str(exact))
    near(found, NEAR_M, NEAR_DEG)
    assert found.radii_m == pytest.approx([0.0], abs=NEAR_M)


@pytest.mark.thorough
@pytest.mark.parametrize("pipe", ["mitre_90_round", "take_branch"])
def test_in_a_flat_round_pipe_a_corner_is_known_to_five_degrees(pipe: str) -> None:
    near(missed_in(row(pipe), 0), NEAR_M, 5.0)


@pytest.mark.thorough
def test_two_bends_in_planes_square_to_each_other_are_both_found() -> None:
    found = missed_in(row("two_bends_up"), 0)
    assert len(found.angles_deg) == 2
    near(found, NEAR_M, 5.0)


@pytest.mark.thorough
def test_a_flat_elbow_is_told_from_a_corner() -> None:
    found = missed_in(row("take_elbow"), 0)
    assert found.radii_m == pytest.approx([0.0], abs=0.03)
    near(found, 0.03, 15.0)
