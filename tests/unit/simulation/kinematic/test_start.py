"""How a chain stands before its first step."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pirate_sm.core.geometry import Route
from pirate_sm.core.models import Friction
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World
from pirate_sm.simulation.physics import ChainBody, StartPose
from pirate_sm.simulation.start_pose import stand

from ..conftest import CYCLE_S, DIAMETER_M, Driver, straight

Place = Callable[..., Driver]

SECTIONS = {"bars": World, "round": SpaceWorld}
ALL_JOINTS = (1, 2, 3, 4)

each_section = pytest.mark.parametrize("section", SECTIONS)


def _statics_n(torque_nm: float, diameter_m: float) -> float:
    """What all wheels together press with where no friction is locked in (thesis, eq. 3-3)."""
    height_m = diameter_m - 0.048
    a, b = (1 / math.sqrt(length_m**2 - height_m**2) for length_m in (0.090, 0.098))
    return torque_nm * (14 * a + 2 * b)


@each_section
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(turn=st.floats(-0.5, 0.5), roll=st.floats(-3.0, 3.0), tilt=st.floats(-1.5, 1.5))
def test_a_robot_that_is_put_back_stands_where_it_stood(
    chain: ChainBody, section: str, turn: float, roll: float, tilt: float
) -> None:
    route = Route(straight(section=section, tilt_rad=abs(tilt), uphill_rad=tilt))
    standing = stand(chain, route, 2.0, {1: -0.5, 2: 0.5}, roll)
    motors = tuple(bend + turn for bend in standing.bends_rad)
    pose = StartPose(
        standing.places, standing.bends_rad, motors, rolls_rad=(0.0, roll, roll), roll_motor_rad=0.1
    )
    physics: Any = SECTIONS[section]
    world = physics(chain, route, Friction(static=0.7, kinetic=0.5), pose, CYCLE_S)
    assert world.places() == list(standing.places)
    assert tuple(world.state.bend) == standing.bends_rad
    assert tuple(world.state.motor) == motors
    assert not world.state.velocity.any()
    assert not world.state.wheel.any()


@each_section
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(duty=st.floats(0.3, 0.9), diameter_m=st.floats(0.11, 0.12), upright=st.booleans())
def test_a_clamped_start_presses_as_a_clamp_without_locked_friction_does(
    place: Place, section: str, duty: float, diameter_m: float, upright: bool
) -> None:
    tilt = {"tilt_rad": math.pi / 2, "uphill_rad": 0.0} if upright else {}
    pipe = straight(diameter_m=diameter_m, section=section, **tilt)
    robot = place(pipe, clamped=duty, physics=SECTIONS[section])
    assert sum(robot.values("press")) == pytest.approx(
        _statics_n(1.01 * duty, diameter_m), rel=0.15
    )
    assert not any(robot.values("wheel"))


@each_section
def test_a_clamped_start_at_half_the_torque_is_where_driving_leaves_it(
    place: Place, section: str
) -> None:
    robot = place(straight(section=section), physics=SECTIONS[section])
    start_n = np.array(robot.values("press"))
    assert 100 < start_n.sum() < 146
    robot.clamp(*ALL_JOINTS)
    before = np.array(robot.physics.places())
    robot.run(1.0)
    assert np.array(robot.physics.places()) == pytest.approx(before, abs=1e-4)
    robot.drive(1.0)
    robot.run(2.0)
    assert start_n == pytest.approx(robot.values("press"), rel=0.1)


@each_section
def test_a_start_without_duty_keeps_the_room_it_has(place: Place, section: str) -> None:
    robot = place(straight(section=section), clamped=0.0, physics=SECTIONS[section])
    aside_m = 0.0 if section == "bars" else DIAMETER_M / 2 - 0.024
    assert np.abs(np.array(robot.physics.places())[:, 2]) == pytest.approx([aside_m] * 6, abs=1e-12)
