"""A coarser simulator: it does the same within millimetres, and the usual one stays what it was."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import pytest

from pirate_sm.core.options import Fidelity
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World, kinematic, notice_of
from pirate_sm.simulation.physics import MakePhysics

from ..conftest import Driver, straight

Place = Callable[..., Driver]


def with_fidelity(fidelity: Fidelity) -> MakePhysics:
    return partial(kinematic, fidelity=fidelity)


def climbing(place: Place, section: str, physics: MakePhysics) -> Driver:
    """Clamp upright, drive up and brake."""
    upright = straight(tilt_rad=math.pi / 2, uphill_rad=0.0, section=section)
    robot = place(upright, physics=physics)
    robot.clamp(1, 2, 3, 4, duty=0.7)
    robot.run(1.0)
    robot.drive(1.0)
    robot.run(2.0)
    robot.drive(0.0)
    robot.run(0.5)
    return robot


@pytest.mark.parametrize("section", ["bars", "round"])
def test_fast_climbs_and_holds_as_usual_within_millimetres(place: Place, section: str) -> None:
    usual = climbing(place, section, with_fidelity("usual"))
    fast = climbing(place, section, with_fidelity("fast"))

    assert fast.arcs != usual.arcs
    assert fast.arcs == pytest.approx(usual.arcs, abs=3e-3)
    held = fast.middle
    fast.run(2.0)
    assert fast.middle == pytest.approx(held, abs=1e-4)


@pytest.mark.parametrize(("section", "physics"), [("bars", World), ("round", SpaceWorld)])
def test_who_names_no_fidelity_has_the_usual_one_to_the_bit(
    place: Place, section: str, physics: MakePhysics
) -> None:
    named = climbing(place, section, with_fidelity("usual"))

    assert climbing(place, section, physics).arcs == named.arcs


def test_only_a_coarser_one_has_something_to_say() -> None:
    assert notice_of("usual") == ""
    assert notice_of("fast").startswith("fast: 2 of 4 iterations")
