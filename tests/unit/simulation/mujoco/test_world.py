from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from pirate_sm.core.errors import BackendError, UsageError
from pirate_sm.core.geometry import Route
from pirate_sm.core.models import Friction, Profile
from pirate_sm.simulation.mujoco.model_text import model_text
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, chain_of
from pirate_sm.simulation.start_pose import stand

from ..conftest import CYCLE_S, Driver, bend, straight

Place = Callable[..., Driver]
FRICTION = Friction(static=0.7, kinetic=0.5)


def frictions(robot: MujocoWorld) -> np.ndarray:
    """Return the coefficients of each wheel: sliding both ways, spinning, rolling."""
    coefficients = robot.model.pair_friction.reshape(6, -1, 5)
    assert (coefficients == coefficients[:, :1]).all()
    return np.array(coefficients[:, 0])


def world(chain: ChainBody, section: str = "bars", friction: Friction = FRICTION) -> MujocoWorld:
    route = Route(straight(section=section))
    return MujocoWorld(chain, route, friction, stand(chain, route, 1.0, {}), CYCLE_S)


@pytest.mark.parametrize("section", ["bars", "round"])
def test_the_model_weighs_what_the_profile_says(profile: Profile, section: str) -> None:
    parts = [*profile.body.wheels, *profile.body.links]
    made = world(chain_of(profile), section).model
    weighed = float(made.body_subtreemass[made.body("link_0").id])
    assert weighed == pytest.approx(sum(part.mass for part in parts))


def test_a_wheel_turns_with_its_rotor(profile: Profile) -> None:
    motors = profile.motors
    given = motors["wheel"].model_copy(update={"rotor_inertia": 0.0123})
    heavy = profile.model_copy(update={"motors": {**motors, "wheel": given}})
    bare = motors["wheel"].model_copy(update={"rotor_inertia": None})
    light = profile.model_copy(update={"motors": {**motors, "wheel": bare}})
    for robot, expected in ((heavy, 0.0123), (light, 0.0)):
        model = world(chain_of(robot)).model
        dof = model.joint("wheel_0").dofadr[0]
        assert model.dof_armature[dof] == pytest.approx(expected)


def test_a_joint_without_a_spring_stays_as_it_stands(chain: ChainBody) -> None:
    joints = {wheel: joint for wheel, joint in chain.joints.items() if wheel != 2}
    robot = world(replace(chain, joints=joints))
    robot.duties[1] = -0.5
    for _ in range(60):
        robot.advance()
    places = np.array(robot.places())
    ahead, behind = places[1] - places[2], places[2] - places[3]
    assert robot.quantities[2] == 0.0
    assert np.cross(ahead, behind) == pytest.approx([0.0] * 3, abs=1e-9)


def test_a_round_pipe_is_48_plates_and_straight(chain: ChainBody) -> None:
    route = Route(straight(section="round"))
    text = model_text(chain, route, stand(chain, route, 1.0, {}), 0.002, space=True)
    walls = fromstring(text).findall("worldbody/geom")
    assert len(walls) == 48
    bent = Route(bend(section="round"))
    with pytest.raises(UsageError, match="no bends in a round pipe"):
        MujocoWorld(chain, bent, FRICTION, stand(chain, bent, 0.7, {}), CYCLE_S)


@pytest.mark.parametrize("section", ["bars", "round"])
def test_a_world_that_is_made_stands_as_it_was_put(chain: ChainBody, section: str) -> None:
    route = Route(straight(section=section))
    pose = stand(chain, route, 1.0, {1: -0.5, 2: 0.5, 3: -0.5, 4: 0.5})
    robot = MujocoWorld(chain, route, FRICTION, pose, CYCLE_S)
    assert np.array(robot.places()) == pytest.approx(np.array(pose.places), abs=1e-12)
    assert not robot.data.qvel.any()


def test_a_loose_robot_begins_on_the_wall_that_it_lies_on(chain: ChainBody) -> None:
    # z of the drawing points down in a pipe that lies flat.
    places = np.array(world(chain, "round").places())
    assert places[:, 2] == pytest.approx([0.06 - 0.024] * 6)
    assert places[:, 1] == pytest.approx([0.0] * 6)


def test_a_robot_is_put_into_space_rolled(place: Place) -> None:
    robot = place(straight(section="round"), roll_rad=0.5, physics=MujocoWorld)
    assert robot.physics.rolls() == pytest.approx([0.0, 0.5, 0.5])


def test_the_coefficient_falls_with_the_speed_of_the_slip(place: Place) -> None:
    robot = place(straight(), at=1.0, friction=(0.08, 0.05), physics=MujocoWorld)
    robot.clamp(1, 2, 3, 4, duty=0.3)
    robot.run(1.0)
    assert frictions(robot.physics)[:, 0] == pytest.approx([0.08] * 6)
    robot.physics.block(0, 1.1, ahead=True)
    robot.drive(1.0)
    robot.run(3.0)
    pressing = np.array(robot.values("press")) > 0.1
    assert frictions(robot.physics)[pressing, 0] == pytest.approx(0.05)
    press, grip = np.array(robot.values("press")), np.abs(robot.values("grip"))
    assert grip[pressing] / press[pressing] == pytest.approx(0.05, rel=0.03)


@pytest.mark.parametrize("section", ["bars", "round"])
def test_wheels_spin_on_the_spot_against_the_friction_of_their_contact(
    chain: ChainBody, section: str
) -> None:
    made = frictions(world(replace(chain, spin_radius_m=0.002), section))
    assert made[:, :3] == pytest.approx(np.array([[0.7, 0.7, 0.7 * 0.002]] * 6))


def test_a_wheel_that_leans_rolls_on_the_edge_of_its_tyre(place: Place) -> None:
    robot = place(straight(section="round"), clamped=0.0, physics=MujocoWorld)
    robot.clamp(1, 2, 3, 4)
    robot.run(15.0)
    world, chain = robot.physics, robot.chain
    edge = chain.tyre_half_width_m / chain.wheel_radius_m
    for wheel, (_, y, z) in enumerate(world.places()):
        wall = np.array([0.0, y, z]) / np.hypot(y, z)
        body = world.model.body(f"wheel_{wheel}").id
        axle, link = (
            world.data.xmat[each, 2::3] for each in (body, world.model.body_parentid[body])
        )
        # Between two plates a wheel leans by up to half their angle more.
        assert abs(link @ wall) > 0.3
        assert abs(axle @ wall) == pytest.approx(edge, abs=np.pi / 48)


def test_a_world_that_has_become_unstable_says_so(
    chain: ChainBody, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo keeps a log where it is
    robot = world(chain)
    robot.data.qvel[0] = np.nan
    with pytest.raises(BackendError, match="unstable"):
        robot.advance()


def test_a_faster_threshold_lets_a_slipping_wheel_keep_its_static_friction(
    chain: ChainBody,
) -> None:
    kept = {}
    for threshold in (0.001, 10.0):
        friction = Friction(static=0.08, kinetic=0.02, threshold=threshold)
        route = Route(straight(tilt_rad=1.5, uphill_rad=0.0))
        duties = {1: -0.1, 2: 0.1, 3: -0.1, 4: 0.1}
        robot = MujocoWorld(chain, route, friction, stand(chain, route, 2.0, duties), CYCLE_S)
        for _ in range(20):
            robot.advance()
        kept[threshold] = float(frictions(robot)[1, 0])
    assert kept == pytest.approx({0.001: 0.02, 10.0: 0.08})
