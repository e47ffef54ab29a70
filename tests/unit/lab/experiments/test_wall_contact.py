from math import isnan

import pytest
from representative import thorough_but

from pirate_sm.lab.experiments.setups import WallContact
from pirate_sm.lab.experiments.wall_contact import bouncing_step_s, rebound_m

WALL = WallContact(stiffness=1000, damping=100, step=1e-3, drop=1e-3, lasting=1)
"""Table 4-1 of the thesis."""


def test_a_wheel_bounces_fiercely_in_explicit_steps_of_a_millisecond_and_never_in_short_ones() -> (
    None
):
    assert rebound_m(WALL, 0.020, 1e-3) > 0.1
    assert rebound_m(WALL, 0.020, 1e-4) == 0


@pytest.mark.parametrize("mass_kg", thorough_but([0.150], [0.020, 0.150]))
def test_it_never_rests_from_the_step_on_in_which_the_damper_increases_a_speed(
    mass_kg: float,
) -> None:
    assert bouncing_step_s(WALL, mass_kg) == pytest.approx(2 * mass_kg / WALL.damping, rel=0.2)


def test_no_part_of_the_robot_swings_on_such_a_wall() -> None:
    for mass_kg in (0.020, 0.150, 0.770):
        assert rebound_m(WALL, mass_kg, 1e-5) == 0


@pytest.mark.parametrize("damping", [1e-3, 1e9])
def test_the_search_ends_where_a_wall_hardly_damps_or_no_step_is_short_enough(
    damping: float,
) -> None:
    wall = WALL.model_copy(update={"damping": damping})

    assert isnan(bouncing_step_s(wall, 0.020))
