"""What any physics of a chain in a pipe must do, and that the two agree."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from representative import thorough_but

from pirate_sm.core.geometry import GRAVITY_M_S2, Route
from pirate_sm.core.models import Friction, Profile
from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld
from pirate_sm.simulation.kinematic.world import World as KinematicWorld
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import ChainBody, MakePhysics, QuantityLayout
from pirate_sm.simulation.start_pose import stand

from .conftest import CYCLE_S, Driver, bend, straight

Place = Callable[..., Driver]

JOINTS = (1, 2, 3, 4)
FRICTION = Friction(static=0.7, kinetic=0.5)
WORLDS = {
    "kinematic, plane": (KinematicWorld, "bars"),
    "kinematic, space": (SpaceWorld, "round"),
    "mujoco, plane": (MujocoWorld, "bars"),
    "mujoco, space": (MujocoWorld, "round"),
}


@pytest.fixture(params=thorough_but(WORLDS.keys() - {"mujoco, space"}, WORLDS))
def put(request: pytest.FixtureRequest, place: Place) -> Place:
    """Puts the robot into a straight pipe in one of the worlds, clamped with half the torque."""
    physics, section = WORLDS[request.param]

    def put_into(upright: bool = False, **more: object) -> Driver:
        tilt = {"tilt_rad": math.pi / 2, "uphill_rad": 0.0} if upright else {}
        return place(straight(section=section, **tilt), physics=physics, **more)

    return put_into


def test_nothing_moves_by_itself(put: Place) -> None:
    robot = put(clamped=0.0)
    before = np.array(robot.physics.places())
    robot.run(2.0)
    assert np.array(robot.physics.places()) == pytest.approx(before, abs=1e-4)


def test_clamped_wheels_press_alternating_walls_with_what_their_joints_bear(put: Place) -> None:
    robot = put()
    robot.clamp(*JOINTS)
    robot.run(1.0)
    robot.drive(1.0)
    robot.run(2.0)
    assert [side > 0 for side in robot.sides()] == [True, False] * 3
    assert robot.values("bend_torque")[1:5] == pytest.approx([-0.505, 0.505] * 2, rel=0.05)
    # Joint k presses its three wheels with its torque over the links' projections (eq. 3-3).
    a = math.sqrt(0.090**2 - 0.072**2)
    b = math.sqrt(0.098**2 - 0.072**2)
    c = 1 / a + 1 / b
    shares = [1 / a, 3 / a, 3 / a + c - 1 / a, 3 / a + c - 1 / a, 3 / a, 1 / a]
    assert robot.values("press") == pytest.approx([0.505 * share for share in shares], rel=0.08)


def test_a_wound_spring_keeps_its_torque_without_duty(put: Place) -> None:
    robot = put()
    robot.run(5.0)
    assert min(robot.values("press")) > 2.0


@pytest.mark.parametrize("resistance", [0.0, 0.02])
def test_driving_level_costs_what_the_tyres_resist(
    put: Place, profile: Profile, resistance: float
) -> None:
    # By hand: each motor bears coefficient times normal force times radius, whatever it turns.
    tyre = profile.simulation.tyre.model_copy(update={"rolling_resistance": resistance})
    simulation = profile.simulation.model_copy(update={"tyre": tyre})
    robot = put(at=2.5, robot=profile.model_copy(update={"simulation": simulation}))
    robot.clamp(*JOINTS)
    robot.run(1.0)
    start = robot.middle
    robot.drive(1.0)
    robot.run(2.0)
    needed_nm = resistance * sum(robot.values("press")) * 0.024
    assert sum(robot.values("drive")) == pytest.approx(needed_nm, rel=0.02, abs=2e-3)
    # A motor slows down by the share of its stall torque that it bears.
    way_m = 2.0 * 0.151 * (1.0 - needed_nm / 6 / 0.3)
    assert robot.middle - start == pytest.approx(way_m, rel=0.02)


@pytest.mark.parametrize("world", WORLDS)
def test_rolling_resistance_stops_a_robot_and_never_drives_it(chain: ChainBody, world: str) -> None:
    physics, section = WORLDS[world]
    free = tuple(replace(wheel, hold_nm=0.0) for wheel in chain.wheels)
    made = replace(chain, wheels=free, rolling_resistance=0.05)
    route = Route(straight(section=section))
    clamped = {1: -0.5, 2: 0.5, 3: -0.5, 4: 0.5}
    robot = physics(made, route, FRICTION, stand(made, route, 2.0, clamped), CYCLE_S)
    robot.duties[1:5] = [-0.5, 0.5, -0.5, 0.5]
    for drive, cycles in ((1.0, 100), (0.0, 100)):
        robot.duties[6:] = [drive, -drive] * 3
        for _ in range(cycles):
            robot.advance()
    at_rest = np.array(robot.places())
    for _ in range(100):
        robot.advance()
    assert at_rest[:, 0].mean() > 1.9
    assert np.array(robot.places()) == pytest.approx(at_rest, abs=2e-4)


@pytest.mark.parametrize("world", WORLDS)
def test_a_motor_too_weak_for_its_tyres_moves_nothing(chain: ChainBody, world: str) -> None:
    physics, section = WORLDS[world]
    made, route = replace(chain, rolling_resistance=0.05), Route(straight(section=section))
    clamped = {1: -0.5, 2: 0.5, 3: -0.5, 4: 0.5}
    robot = physics(made, route, FRICTION, stand(made, route, 2.0, clamped), CYCLE_S)
    robot.duties[1:5] = [-0.5, 0.5, -0.5, 0.5]
    layout = QuantityLayout(6)
    robot.duties[6:] = [0.03, -0.03] * 3
    for _ in range(100):
        robot.advance()
    start = np.array(robot.places())
    for _ in range(200):
        robot.advance()
    assert np.array(robot.places()) == pytest.approx(start, abs=3e-4)
    assert robot.quantities[layout.block("drive")] == pytest.approx([0.009] * 6, rel=0.05)


@pytest.mark.parametrize("duty", thorough_but([-0.4], [1.0, -0.4]))
def test_the_robot_goes_as_far_as_its_wheels_roll(put: Place, duty: float) -> None:
    robot = put(at=2.5)
    robot.clamp(*JOINTS)
    robot.run(1.0)
    start, turned = robot.middle, np.array(robot.values("wheel"))
    robot.drive(duty)
    robot.run(4.0)
    rolled = 0.024 * (np.array(robot.values("wheel")) - turned) * [1, -1, 1, -1, 1, -1]
    assert robot.middle - start == pytest.approx(0.15 * duty * 4.0, rel=0.03)
    # In a round pipe it hangs some mm below the axis, where wheels lean: on smaller circles.
    assert rolled.mean() == pytest.approx(robot.middle - start, rel=4e-3)


def _below_the_axis_m(robot: Driver) -> float:
    """How far the robot's plane is below the axis of the pipe, the mean of its wheels."""
    return float(np.array(robot.physics.places())[:, 2].mean())


def test_a_robot_that_clamps_beside_the_axis_creeps_to_it_as_it_drives(place: Place) -> None:
    robot = place(straight(section="round"), at=1.5, clamped=0.0, physics=SpaceWorld)
    robot.clamp(*JOINTS)
    robot.run(20.0)
    clamped_m = _below_the_axis_m(robot)
    assert clamped_m > 0.01
    robot.run(5.0)
    assert _below_the_axis_m(robot) == pytest.approx(clamped_m, abs=1e-3)
    robot.drive(1.0)
    robot.run(5.0)
    assert _below_the_axis_m(robot) < clamped_m / 2


def test_a_robot_that_drives_hangs_below_the_axis_by_its_weight(place: Place) -> None:
    """Where tyres creep no more: walls bear weight / forces of the clamps as sine of the lean."""
    robot = place(straight(section="round"), at=1.0, physics=SpaceWorld)
    robot.clamp(*JOINTS)
    robot.run(0.5)
    robot.drive(1.0)
    robot.run(6.0)
    parts = [*robot.chain.wheels, *robot.chain.links]
    sine = GRAVITY_M_S2 * sum(part.mass_kg for part in parts) / sum(robot.values("press"))
    assert _below_the_axis_m(robot) == pytest.approx(sine * (0.06 - 0.024), rel=0.2)


def test_a_clamped_robot_holds_upright_and_climbs(put: Place) -> None:
    robot = put(upright=True)
    robot.clamp(*JOINTS, duty=0.7)
    robot.run(1.0)
    start = robot.middle
    robot.run(5.0)
    assert robot.middle == pytest.approx(start, abs=5e-4)  # MuJoCo creeps by 0.06 mm/s
    robot.drive(1.0)
    robot.run(4.0)
    assert robot.middle - start > 0.3


def test_wheels_that_climb_a_slippery_pipe_roll_as_far_as_the_robot_moves(put: Place) -> None:
    """The bound of a distance counts no creep along the drive."""
    robot = put(upright=True, friction=(0.2, 0.15))
    robot.clamp(*JOINTS, duty=0.7)
    robot.run(1.0)
    robot.drive(1.0)
    robot.run(1.0)
    start, turned = robot.middle, np.array(robot.values("wheel"))
    robot.run(3.0)
    rolled = 0.024 * (np.array(robot.values("wheel")) - turned) * [1, -1, 1, -1, 1, -1]
    assert robot.middle - start > 0.2
    assert rolled.mean() == pytest.approx(robot.middle - start, rel=4e-3)


def test_it_slides_down_where_friction_is_too_low(put: Place) -> None:
    robot = put(upright=True, at=2.0, friction=(0.03, 0.02))
    start = robot.middle
    robot.run(0.5)
    assert robot.middle < start - 0.3


def test_wheels_slip_against_an_obstacle_only_where_friction_is_low(put: Place) -> None:
    turned = {}
    for friction in (0.08, 0.7):
        robot = put(at=1.0, friction=(friction, friction))
        robot.clamp(*JOINTS, duty=0.3)
        robot.run(1.0)
        robot.physics.block(0, 1.1, ahead=True)
        robot.drive(1.0)
        robot.run(3.0)
        wheels = np.array(robot.values("wheel"))
        assert robot.arcs[0] == pytest.approx(1.1 - 0.024, abs=3e-3)
        robot.run(1.0)
        turned[friction] = np.abs(np.array(robot.values("wheel")) - wheels).max()
    assert turned[0.08] > 0.5
    assert turned[0.7] < 0.05
    robot.physics.unblock()
    robot.run(1.0)
    assert robot.arcs[0] > 1.1


def test_a_joint_stops_at_its_end_stop(put: Place) -> None:
    robot = put(clamped=0.0)
    robot.clamp(1, duty=1.0)
    robot.run(5.0)
    assert abs(robot.values("bend")[1]) < math.radians(120.5)


def test_a_dead_wheel_drags_and_a_stiff_joint_resists(put: Place) -> None:
    robot = put()
    robot.physics.disable_wheel(2, 0.05)
    robot.clamp(*JOINTS)
    robot.run(0.5)
    robot.drive(1.0)
    robot.run(1.5)
    assert robot.values("drive")[2] == pytest.approx(0.05, abs=0.015)
    stiff, usual = put(clamped=0.0), put(clamped=0.0)
    stiff.physics.stiffen_joint(1, 0.3)
    for each in (stiff, usual):
        each.clamp(1, duty=0.25)
        each.run(0.5)
    assert abs(stiff.values("bend")[1]) < 0.2 * abs(usual.values("bend")[1])


def test_the_inertial_unit_feels_gravity_turned(put: Place) -> None:
    robot = put()
    robot.clamp(*JOINTS)
    robot.run(0.5)
    flat = [robot.value(axis) for axis in ("acc_x", "acc_y", "acc_z")]
    robot.physics.turn_gravity((1.0, 0.0, 0.0))
    robot.run(1.0)
    upright = [robot.value(axis) for axis in ("acc_x", "acc_y", "acc_z")]
    assert flat == pytest.approx([0.0, 0.0, GRAVITY_M_S2], abs=0.3)
    assert math.hypot(*upright[:2]) == pytest.approx(GRAVITY_M_S2, abs=0.3)
    assert upright[2] == pytest.approx(0.0, abs=0.3)


def test_the_inertial_unit_averages_between_its_reports(put: Place) -> None:
    """A jerk of one cycle is not what it shows for a whole round of the boards."""
    robot = put()
    robot.clamp(*JOINTS)
    robot.run(0.5)
    before = robot.value("acc_z")
    robot.physics.turn_gravity((1.0, 0.0, 0.0))
    robot.run(0.016)
    assert 0.8 * before < robot.value("acc_z") < 0.95 * before


def test_a_wheel_that_grips_less_lets_the_robot_slide(put: Place) -> None:
    robot = put(upright=True, at=2.0)
    robot.clamp(*JOINTS)
    robot.run(0.5)
    start = robot.middle
    for wheel in range(6):
        robot.physics.let_grip(wheel, 0.03, 0.02)
    robot.run(0.4)
    assert robot.middle < start - 0.2


def test_the_roll_joint_of_a_loose_robot_turns_a_part(put: Place) -> None:
    robot = put(clamped=0.0)
    robot.physics.turn_roll_to(math.pi / 4)
    robot.run(4.0)
    assert robot.value("roll") == pytest.approx(math.pi / 4, abs=0.05)
    _, front, rear = robot.physics.rolls()
    assert front - rear == pytest.approx(math.pi / 4, abs=0.05)


@pytest.mark.parametrize("begins", [{3: -0.7, 4: 0.7}, {1: -0.5, 2: 0.5, 3: -0.5, 4: 0.5}])
def test_both_physics_agree_on_clamping_the_front(place: Place, begins: dict[int, float]) -> None:
    robots = []
    for physics in (KinematicWorld, MujocoWorld):
        robot = place(straight(), duties=begins, physics=physics)
        for wheel, duty in begins.items():
            robot.physics.duties[wheel] = duty
        robot.run(1.0)
        robot.clamp(1, 2, duty=0.7)
        robot.run(3.0)
        robots.append(robot)
    torques, places = (
        [np.array(robot.values("bend_torque")) for robot in robots],
        [np.array(robot.physics.places()) for robot in robots],
    )
    assert torques[0] == pytest.approx(torques[1], abs=0.05)
    assert places[0] == pytest.approx(places[1], abs=3e-3)


def test_plane_and_space_agree_on_a_drive(place: Place) -> None:
    ways = []
    for physics, section in WORLDS.values():
        robot = place(straight(section=section), physics=physics)
        robot.clamp(*JOINTS)
        robot.run(0.5)
        start = robot.middle
        robot.drive(1.0)
        robot.run(3.0)
        ways.append(robot.middle - start)
    kinematic, kinematic_space, mujoco, mujoco_space = ways
    # In space it hangs 2 mm below the axis, in MuJoCo between two plates.
    assert mujoco == pytest.approx(mujoco_space, abs=2e-3)
    assert kinematic == pytest.approx(kinematic_space, abs=1e-3)
    assert kinematic == pytest.approx(mujoco, rel=0.03)


@pytest.mark.parametrize("physics", [KinematicWorld, MujocoWorld])
def test_equal_calls_give_equal_quantities_to_the_last_bit(
    place: Place, physics: MakePhysics
) -> None:
    runs = []
    for _ in range(2):
        robot = place(bend(), at=0.95, physics=physics)
        robot.clamp(*JOINTS)
        robot.drive(1.0)
        robot.run(30 * CYCLE_S)
        runs.append(robot.physics.quantities.tobytes())
    assert runs[0] == runs[1]
