from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pirate_sm.core._geometry.network import Mitre, Reducer, Straight, planar
from pirate_sm.core.geometry import Network, Vector
from pirate_sm.core.models import Profile
from pirate_sm.simulation.kinematic import columns as plane
from pirate_sm.simulation.kinematic.space import columns
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World, kinematic
from pirate_sm.simulation.physics import PER_WHEEL, SINGLE, chain_of

from ..conftest import DIAMETER_M, Driver, bend, straight

Place = Callable[..., Driver]

ALL_JOINTS = (1, 2, 3, 4)
BODY = (
    *("MASS_INV", "MU_STATIC", "MU_KINETIC", "WHEEL_RATE", "WHEEL_STALL", "WHEEL_HOLD"),
    *("MOTOR_LINK", "JOINT_K", "JOINT_RATE", "JOINT_STALL", "JOINT_FRICTION", "JOINT_MIN"),
    *("JOINT_MAX", "JOINT_DAMPING", "LINK_LENGTH", "BODY_COLUMNS"),
)


def round_pipe(**more: object) -> Network:
    return straight(section="round", **more)


def into_bend(robot: Driver) -> None:
    """Clamp, drive up to the mitre, bend the front into the far leg and push it in."""
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.drive(1.0)
    robot.run(1.2)
    robot.drive(0.0)
    robot.clamp(1, duty=0.3)
    robot.physics.duties[2] = -0.3
    robot.run(3.0)
    robot.drive(0.6)
    robot.run(1.0)


def test_both_kernels_have_one_layout_of_a_chain_and_of_quantities() -> None:
    for name in BODY:
        assert getattr(plane, name) == getattr(columns, name), name
    assert len(BODY) == columns.BODY_COLUMNS + 1
    assert len(PER_WHEEL) == columns.OUT_PER_WHEEL
    assert len(SINGLE) == columns.OUT_SINGLE


def test_a_round_pipe_takes_the_kernel_in_space(place: Place) -> None:
    assert isinstance(place(round_pipe(), physics=kinematic).physics, SpaceWorld)
    assert isinstance(place(straight(), physics=kinematic).physics, World)


def test_where_gravity_lies_in_the_plane_both_kernels_enter_a_bend_alike(
    place: Place,
) -> None:
    # Flat, the planar kernel lets wheels drag on the plate below; a round pipe has none.
    tilt = {"tilt_rad": math.pi / 2, "uphill_rad": math.radians(135)}
    ways = []
    for section, physics in (("bars", World), ("round", SpaceWorld)):
        robot = place(bend(section=section, **tilt), at=0.8, physics=physics)
        into_bend(robot)
        ways.append(np.array(robot.physics.places()))
    assert ways[1][0, 1] > 0.05  # beyond where the straight pipe lets it
    assert ways[0] == pytest.approx(ways[1], abs=5e-4)


@pytest.mark.parametrize("roll", [0.6, math.pi / 2, -2.0])
def test_it_is_the_same_pipe_however_it_is_rolled(place: Place, roll: float) -> None:
    ways = []
    for angle in (0.0, roll):
        up = (0.0, math.sin(0.5 - angle), -math.cos(0.5 - angle))
        parts = (Straight(1.0), Mitre(math.pi / 2, angle), Straight(1.0))
        robot = place(
            _standing(planar(DIAMETER_M, parts, section="round"), up),
            at=0.8, roll_rad=angle, physics=SpaceWorld,
        )  # fmt: skip
        into_bend(robot)
        ways.append(robot)
    assert max(ways[0].arcs) > 0.95
    assert ways[1].arcs == pytest.approx(ways[0].arcs, abs=1e-3)
    assert ways[1].values("bend") == pytest.approx(ways[0].values("bend"), abs=0.02)
    assert ways[1].physics.rolls()[2] == pytest.approx(roll, abs=0.05)


def _standing(network: Network, up: Vector) -> Network:
    return Network(network.runs, network.routes, up)


def test_a_clamped_robot_stays_where_the_pipe_is_widest(place: Place) -> None:
    # Its springs press it there, even with hardly any friction across.
    for friction in ((0.7, 0.5), (0.1, 0.05)):
        robot = place(round_pipe(), friction=friction, physics=SpaceWorld)
        robot.clamp(*ALL_JOINTS)
        robot.run(3.0)
        assert np.array(robot.physics.places())[:, 2] == pytest.approx([0.0] * 6, abs=2e-3)


def test_a_loose_robot_lies_on_the_floor_and_swings_through_the_lowest_place(
    place: Place,
) -> None:
    robot = place(round_pipe(), clamped=0.0, physics=SpaceWorld)
    floor = DIAMETER_M / 2 - 0.024
    assert np.array(robot.physics.places())[:, 2] == pytest.approx([floor] * 6, abs=1e-4)
    robot.physics.turn_gravity((0.0, -1.0, 0.0))
    heights = []
    for _ in range(60):
        robot.physics.advance()
        heights.append(np.array(robot.physics.places())[:, 1])
    # It rolls through the lowest place and swings there like a pendulum.
    assert np.array(heights).max() == pytest.approx(floor, abs=1e-3)


def test_wheels_that_are_forced_over_a_narrow_step_stay_out_of_the_wall(place: Place) -> None:
    step = planar(0.122, (Straight(1.0), Reducer(0.0, 0.112), Straight(1.0)), section="round")
    robot = place(step, at=0.8, physics=SpaceWorld)
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.drive(1.0)
    pressed_n = 0.0
    while robot.middle < 1.1:  # when its wheels are over it, they are pressed less
        robot.run(0.1)
        pressed_n = max(pressed_n, *robot.values("press"))
    assert pressed_n > 100.0
    robot.run(5.0)
    assert robot.physics.deepest_m < 2e-3


def test_the_roll_motor_stalls_where_both_parts_are_clamped(place: Place) -> None:
    robot = place(round_pipe(), physics=SpaceWorld)
    robot.clamp(*ALL_JOINTS)
    robot.run(0.5)
    robot.physics.turn_roll_to(1.0)
    robot.run(5.0)
    assert 0.0 < robot.value("roll") < 0.8
    assert robot.value("roll_current") == pytest.approx(1.0, abs=0.02)
    robot.physics.turn_roll_to(robot.value("roll"))
    robot.run(1.0)
    assert robot.value("roll_current") < 0.9


def test_a_robot_without_a_roll_joint_stays_in_one_plane(
    place: Place, small_profile: Profile
) -> None:
    assert chain_of(small_profile).roll_link == -1
    network = straight(diameter_m=0.1, section="round")
    robot = place(network, robot=small_profile, clamped=0.0, roll_rad=0.3, physics=SpaceWorld)
    robot.physics.turn_roll_to(1.0)
    robot.run(2.0)
    angle, front, rear = robot.physics.rolls()
    assert angle == pytest.approx(0.0, abs=0.01)
    assert front == pytest.approx(rear, abs=0.01)


def test_wheels_and_links_stay_out_of_the_walls_of_a_mitre(place: Place) -> None:
    robot = place(bend(section="round"), at=0.8, physics=SpaceWorld)
    into_bend(robot)
    assert 1e-5 < robot.physics.deepest_m < 2e-3


def test_a_robot_that_leaves_the_pipe_falls_and_all_its_quantities_are_numbers(
    place: Place,
) -> None:
    robot = place(straight(1.0, section="round"), at=0.9, physics=SpaceWorld)
    robot.clamp(*ALL_JOINTS)
    robot.drive(1.0)
    robot.run(20.0)
    assert min(z for _, _, z in robot.physics.places()) > 1.0
    assert np.isfinite(robot.physics.quantities).all()
    assert np.isfinite(robot.physics.state.array).all()


@pytest.mark.parametrize(("length_m", "pitch"), [(1.0, 40), (1.2, 60), (1.2, 80), (1.0, 85)])
def test_a_robot_that_topples_over_the_rim_of_an_upper_end_stays_a_robot(
    place: Place, length_m: float, pitch: float
) -> None:
    upwards = straight(length_m, section="round", tilt_rad=math.radians(pitch))
    robot = place(upwards, at=length_m - 0.3, physics=SpaceWorld)
    robot.clamp(*ALL_JOINTS)
    robot.drive(1.0)
    robot.run(12.0)
    assert np.isfinite(robot.physics.state.array).all()
    places = robot.physics.places()
    assert max(map(math.dist, places, places[1:])) < 0.13


def test_equal_calls_give_equal_quantities_in_a_bend(place: Place) -> None:
    runs = []
    for _ in range(2):
        robot = place(bend(section="round"), at=0.8, physics=SpaceWorld)
        into_bend(robot)
        runs.append(robot.physics.quantities.tobytes())
    assert runs[0] == runs[1]


@pytest.mark.parametrize("off_m", [0.0, 0.005, 0.012])
def test_a_leaning_wheel_rolls_at_least_on_the_edge_of_its_tyre(place: Place, off_m: float) -> None:
    # Beside the middle of the pipe the walls lean; a tyre of 12 mm touches 6 mm aside at most.
    robot = place(round_pipe(), at=1.0, physics=SpaceWorld)
    physics: Any = robot.physics
    physics.state.position[:, 2] += off_m
    robot.clamp(*ALL_JOINTS)
    robot.run(0.2)
    start, turned = robot.middle, np.array(robot.values("wheel"))
    robot.drive(1.0)
    robot.run(0.5)
    rolled_m = 0.024 * np.abs(np.array(robot.values("wheel")) - turned).mean()
    assert 1.0 < rolled_m / (robot.middle - start) + 0.005 < 0.01 + 1 / math.sqrt(1 - (6 / 24) ** 2)
