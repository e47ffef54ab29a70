"""A robot in space is put back in the planes in which its parts lay."""

from __future__ import annotations

from typing import Any

import pytest
from representative import thorough_but

from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.simulation.kinematic.space import columns
from pirate_sm.simulation.physics import StartPose
from pirate_sm.simulation.start_pose import normals_of


@pytest.mark.parametrize("mission", thorough_but(["take_branch"], ["take_branch", "two_bends_up"]))
def test_the_normals_of_the_parts_follow_from_places_and_rolls(mission: str) -> None:
    prepared = prepare(Order(mission, check=False))
    MissionRun(prepared.engine, prepared.backend, companions=prepared.companions).execute()
    physics: Any = vars(prepared.backend)["robot"].physics
    for _ in range(125):  # 2 s, in which it comes to rest
        physics.advance()
    places, rolls = tuple(physics.places()), tuple(physics.rolls())
    still = (0.0,) * len(places)

    pose = StartPose(places, still, still, rolls_rad=rolls)
    link = int(physics._world[columns.ROLL_LINK])
    found = normals_of(pose, prepared.loaded.pipe.route(), link)

    for normal, true in zip(found, physics.state.normals, strict=True):
        assert normal == pytest.approx(tuple(true), abs=1e-6)
