"""What drags on wheels that slide: on the floor, and along a wall with little force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pirate_sm.core.geometry import GRAVITY_M_S2, Route
from pirate_sm.core.models import Friction
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, QuantityLayout
from pirate_sm.simulation.start_pose import stand

from ..conftest import CYCLE_S, straight

STATIC, KINETIC = 0.7, 0.5


def loose(chain: ChainBody, diameter_m: float = 0.12) -> MujocoWorld:
    route = Route(straight(diameter_m=diameter_m))
    friction = Friction(static=STATIC, kinetic=KINETIC)
    return MujocoWorld(chain, route, friction, stand(chain, route, 1.5, {}), CYCLE_S)


@pytest.mark.parametrize("way_deg", [0.0, 30.0, 45.0, 90.0])
def test_the_floor_drags_by_the_same_force_whichever_way_a_robot_slides(
    chain: ChainBody, way_deg: float
) -> None:
    world = loose(chain, diameter_m=1.0)
    way = np.array([np.cos(np.radians(way_deg)), np.sin(np.radians(way_deg))])
    world.data.qvel[:2] = 0.8 * way
    world.advance()
    before = world.data.qvel[:2] @ way
    for _ in range(5):
        world.advance()
    lost = (before - world.data.qvel[:2] @ way) / (5 * CYCLE_S)
    assert lost == pytest.approx(KINETIC * GRAVITY_M_S2, rel=0.03)


def test_a_wheel_that_slides_lightly_along_a_wall_has_its_kinetic_friction(
    chain: ChainBody,
) -> None:
    """The front bends until its second wheel slides along a wall, pressed with about 1 N."""
    quick = {at: replace(joint, rate_rad_s=1.0) for at, joint in chain.joints.items()}
    world = loose(replace(chain, joints=quick))
    world.duties[1], world.duties[2] = -0.7, 0.7
    wheel, layout = 1, QuantityLayout(chain.nodes)
    coefficients: list[float] = []
    arc_m = 0.0
    for _ in range(130):
        world.advance()
        places = world.places()
        at_wall = abs(places[wheel][1]) > 0.06 - chain.wheel_radius_m - 5e-4
        speed_m_s = abs(places[wheel][0] - arc_m) / CYCLE_S
        arc_m = places[wheel][0]
        third_is_free = world.quantities[layout.block("press")][2] == 0.0
        if at_wall and third_is_free and speed_m_s > 0.01:
            coefficients.append(float(world.model.pair_friction.reshape(6, -1, 5)[wheel, 0, 0]))
    assert len(coefficients) > 15
    sliding = [each for each in coefficients if each == pytest.approx(KINETIC)]
    assert len(sliding) > 0.8 * len(coefficients)
