"""Maps of simulated runs beside the pipes that were driven."""

from __future__ import annotations

import pytest
from representative import thorough_but

from benchmarks.maps import NEAR_DEG, NEAR_M, ROWS, Missed, Row, missed_in

SEEDS = range(3)
"""Each has its own start, friction, diameter, noise, and errors of the detector's words."""


def row(name: str) -> Row:
    return next(each for each in ROWS if each.name == name)


def near(found: Missed, metres: float, degrees: float) -> None:
    assert found.notes == ()
    assert found.lengths_m == pytest.approx([0.0] * len(found.lengths_m), abs=metres)
    assert found.angles_deg == pytest.approx([0.0] * len(found.angles_deg), abs=degrees)
    assert found.rolls_deg == pytest.approx([0.0] * len(found.rolls_deg), abs=degrees)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", thorough_but({SEEDS[0]}, SEEDS))
@pytest.mark.parametrize("mission", ["house_connection", "house_connection_back"])
def test_the_map_of_a_house_connection_equals_its_file(mission: str, seed: int) -> None:
    found = missed_in(row(mission), seed)
    assert len(found.lengths_m) == 4  # main, riser before and behind its reducer, the leg behind
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
