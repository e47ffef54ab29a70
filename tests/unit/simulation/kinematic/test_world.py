from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from pirate_sm.core.models import Profile
from pirate_sm.simulation.kinematic import columns
from pirate_sm.simulation.physics import PER_WHEEL, SINGLE, chain_of

from ..conftest import CYCLE_S, DIAMETER_M, Driver, bend, straight, vertical

Place = Callable[..., Driver]

ALL_JOINTS = (1, 2, 3, 4)


def test_clamping_presses_wheels_on_alternating_walls(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    robot.clamp(*ALL_JOINTS)
    robot.run(16.0)
    sides = robot.sides()
    assert [side > 0 for side in sides] == [True, False] * 3
    assert [abs(side) for side in sides] == pytest.approx([DIAMETER_M / 2 - 0.024] * 6, abs=2e-3)
    assert robot.values("bend_torque")[1] == pytest.approx(-0.5 * 1.01, rel=0.1)


def test_the_clamp_force_follows_the_torque(place: Place) -> None:
    # Eq. 3-3: F = torque / sqrt(l^2 - h^2) * (1, 2, 1). Wheels that stand still lock friction in
    # and with it any force; only the outer wheel of a rolling robot is compared, loosely.
    robot = place(straight())
    robot.clamp(*ALL_JOINTS)
    robot.drive(1.0)
    robot.run(3.0)
    h = DIAMETER_M - 2 * 0.024
    expected = 0.5 * 1.01 / math.sqrt(0.09**2 - h**2)
    assert robot.values("press")[0] == pytest.approx(expected, rel=0.2)


def test_a_spring_that_is_wound_up_stays_so_without_duty(place: Place) -> None:
    robot = place(straight())
    robot.run(5.0)
    assert min(robot.values("press")) > 2.0


@pytest.mark.parametrize("duty", [1.0, -1.0, 0.4])
def test_the_driven_distance_is_that_of_the_wheels(place: Place, duty: float) -> None:
    robot = place(straight(), at=2.5)
    robot.clamp(*ALL_JOINTS)
    robot.run(1.0)
    start = robot.middle
    turned = np.array(robot.values("wheel"))
    robot.drive(duty)
    robot.run(8.0)
    distance = robot.middle - start
    rolled = 0.024 * (np.array(robot.values("wheel")) - turned) * [1, -1, 1, -1, 1, -1]
    assert distance == pytest.approx(0.15 * duty * 8.0, rel=0.03)
    # Wheels creep apart by millimetres while the clamp settles, whatever the distance.
    assert rolled == pytest.approx([distance] * 6, abs=3e-3)
    assert rolled.mean() == pytest.approx(distance, rel=1e-3)


def test_a_clamped_robot_holds_in_a_vertical_pipe(place: Place) -> None:
    robot = place(vertical(), at=2.0)
    robot.clamp(*ALL_JOINTS)
    robot.run(1.0)
    start = robot.middle
    robot.run(10.0)
    assert abs(robot.middle - start) < 1e-4


def test_it_climbs(place: Place) -> None:
    robot = place(vertical(), at=1.0)
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.run(1.0)
    start = robot.middle
    robot.drive(1.0)
    robot.run(5.0)
    assert robot.middle - start > 0.3


def test_it_slides_down_where_friction_is_too_low(place: Place) -> None:
    robot = place(vertical(), at=2.0, friction=(0.03, 0.02))
    robot.run(0.5)
    assert robot.middle < 2.0 - 0.27 - 0.3


def test_an_unclamped_robot_in_a_flat_pipe_stays(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    start = robot.middle
    robot.run(5.0)
    assert robot.middle == pytest.approx(start, abs=1e-6)


def test_a_start_with_one_part_bent_has_the_other_clamped_on_its_own_walls(place: Place) -> None:
    # The front pushes, the rear is clamped.
    robot = place(straight(), duties={2: -0.3, 3: -0.7, 4: 0.7})
    assert [side > 0 for side in robot.sides()] == [True, False] * 3


@pytest.mark.parametrize("duty", [0.3, 0.7])
def test_a_blocked_wheel_that_grips_does_not_turn(place: Place, duty: float) -> None:
    robot = place(straight(), at=1.0, friction=(0.7, 0.5))
    robot.clamp(*ALL_JOINTS, duty=duty)
    robot.run(1.0)
    robot.physics.block(0, 1.1, ahead=True)
    robot.drive(1.0)
    robot.run(3.0)
    before = np.array(robot.values("wheel"))
    robot.run(1.0)
    forces = np.abs(robot.values("grip")) / np.array(robot.values("press"))
    assert forces[0] < 0.2  # it grips: 0.7 would let it slip
    assert forces.max() < 0.5
    assert 0.024 * np.abs(np.array(robot.values("wheel")) - before).max() < 5e-4


def test_wheels_slip_against_an_obstacle_where_friction_is_low(place: Place) -> None:
    robot = place(straight(), at=1.0, friction=(0.08, 0.06))
    robot.clamp(*ALL_JOINTS, duty=0.3)
    robot.run(1.0)
    robot.physics.block(0, 1.1, ahead=True)
    robot.drive(1.0)
    robot.run(3.0)
    held = robot.arcs[0]
    wheels = robot.values("wheel")
    robot.run(2.0)
    assert robot.arcs[0] == pytest.approx(held, abs=2e-3)
    assert held == pytest.approx(1.1 - 0.024, abs=3e-3)
    turned = [abs(b - a) for a, b in zip(wheels, robot.values("wheel"), strict=True)]
    assert max(turned) > 1.0  # they turn on, the robot does not move
    robot.physics.unblock()
    robot.run(2.0)
    assert robot.arcs[0] > held + 0.1


def test_the_sign_of_a_joint_turns_the_body_ahead_to_side_a(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    robot.physics.duties[1] = -0.5
    robot.run(0.5)
    sides = robot.sides()
    assert robot.values("bend")[1] < -0.05
    assert sides[0] > sides[1]


def test_a_mirrored_start_is_clamped_on_the_other_walls(place: Place) -> None:
    robot = place(straight(), clamped=-0.5)
    assert [side > 0 for side in robot.sides()] == [False, True] * 3
    robot.run(1.0)
    assert min(robot.values("press")) > 2.0


@pytest.mark.parametrize(("hold_mnm", "turns"), [(300, False), (20, True)])
def test_a_wheel_at_duty_0_resists_with_its_hold_torque(
    profile: Profile, place: Place, hold_mnm: float, turns: bool
) -> None:
    robot = place(vertical(), at=4.5, robot=_wheels(profile, hold_torque=hold_mnm))
    robot.run(0.2)
    before = robot.values("wheel")
    robot.run(0.5)
    turned = [abs(b - a) for a, b in zip(before, robot.values("wheel"), strict=True)]
    # The robot weighs 7.6 N, which is 31 mNm at each of its six wheels.
    assert (min(turned) > 1.0) is turns
    assert (max(turned) < 1e-3) is not turns


def _wheels(profile: Profile, **torques_mnm: float) -> Profile:
    """The robot with other torques of its wheel motors."""
    changed = {key: value / 1000 for key, value in torques_mnm.items()}
    motor = profile.motors["wheel"].model_copy(update=changed)
    return profile.model_copy(update={"motors": {**profile.motors, "wheel": motor}})


def test_a_joint_that_no_pipe_holds_back_folds_to_120_deg_and_no_farther(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    # Far outside the pipe, where nothing holds a joint back.
    robot.physics.state.position[:, 0] -= 5.0
    robot.physics.duties[4] = 1.0
    robot.run(8.0)
    assert math.degrees(robot.values("bend")[4]) == pytest.approx(120.0, abs=1.0)


def _turn(robot: Driver, angle_rad: float, seconds: float) -> tuple[float, float, float]:
    """Ask the roll joint for an angle; the angles of the joint and of both parts after a time."""
    robot.physics.turn_roll_to(angle_rad)
    robot.run(seconds)
    roll, front, rear = robot.physics.state.roll.tolist()
    return roll, front, rear


def _bring(robot: Driver, seconds: float, **angles_deg: float) -> None:
    """Bring the joints at these wheels to angles, each by a motor that runs until it is there."""
    for _ in range(round(seconds / CYCLE_S)):
        for name, angle in angles_deg.items():
            wheel = int(name.removeprefix("at_"))
            left = math.radians(angle) - robot.values("bend")[wheel]
            robot.physics.duties[wheel] = math.copysign(0.5, left) if abs(left) > 0.05 else 0.0
        robot.physics.advance()


_APEX_DEG = 2 * math.degrees(math.asin((DIAMETER_M - 0.048) / 0.09))


@pytest.mark.parametrize("relaxed", [(), (1, 2), (3, 4), ALL_JOINTS])
def test_a_part_that_presses_on_the_walls_does_not_turn(
    place: Place, relaxed: tuple[int, ...]
) -> None:
    robot = place(straight())
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.run(2.0)
    robot.clamp(*relaxed, duty=0.0)  # the worm stays wound
    assert _turn(robot, math.pi / 2, 3.0) == (0.0, 0.0, 0.0)
    assert robot.value("roll_current") == 1.0


def test_the_front_turns_once_the_rear_holds_with_its_apex_alone(place: Place) -> None:
    robot = place(straight())
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.run(2.0)
    _bring(robot, 6.0, at_1=0.0, at_2=0.0, at_3=-_APEX_DEG / 2)
    assert robot.values("press")[2] == 0.0  # wheel 3 is clear of the wall
    assert min(robot.values("press")[3:]) > 4.0  # wheels 4, 5, 6 hold
    turned = _turn(robot, math.pi / 2, 5.0)
    assert turned == pytest.approx((math.pi / 2, math.pi / 2, 0.0))
    assert robot.value("roll_current") == 0.0


def test_the_rear_turns_the_other_way_once_the_front_holds_with_its_apex_alone(
    place: Place,
) -> None:
    robot = place(straight())
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.run(2.0)
    _bring(robot, 6.0, at_2=_APEX_DEG / 2, at_3=0.0, at_4=0.0)
    turned = _turn(robot, math.pi / 2, 5.0)
    assert turned == pytest.approx((math.pi / 2, 0.0, -math.pi / 2))


@pytest.mark.parametrize("held", [ALL_JOINTS[:2], ALL_JOINTS[2:]])
def test_a_part_that_holds_with_its_apex_alone_stays_where_it_is_in_a_vertical_pipe(
    place: Place, held: tuple[int, ...]
) -> None:
    robot = place(vertical(), at=2.0)
    robot.clamp(*ALL_JOINTS, duty=0.7)
    robot.run(2.0)
    apex, half = (1, _APEX_DEG / 2) if held == (1, 2) else (4, -_APEX_DEG / 2)
    start = robot.arcs[apex]
    loose = {f"at_{wheel}": 0.0 for wheel in ALL_JOINTS if wheel not in held}
    beside = next(wheel for wheel in held if wheel != apex)
    _bring(robot, 6.0, **loose, **{f"at_{beside}": half})
    _turn(robot, math.pi / 2, 10.0)
    assert abs(robot.physics.state.roll[0]) == pytest.approx(math.pi / 2)
    assert robot.arcs[apex] == pytest.approx(start, abs=2e-3)


def test_a_part_that_lies_in_the_pipe_turns_against_its_friction(place: Place) -> None:
    robot = place(straight(), clamped=0.0)
    assert _turn(robot, 1.5, 3.0)[0] == pytest.approx(1.5)


def test_the_accelerometer_feels_tilt_and_roll(place: Place) -> None:
    tilt = math.radians(28)
    robot = place(bend(tilt_rad=tilt), at=0.7)
    robot.run(0.5)
    x, y, z = (robot.value(f"acc_{axis}") for axis in "xyz")
    # Link 3 of a clamped robot is not parallel to the pipe: forward and across share the tilt.
    assert math.hypot(x, y) == pytest.approx(9.81 * math.sin(tilt), rel=0.02)
    assert z == pytest.approx(9.81 * math.cos(tilt), rel=0.01)
    rolled = place(straight(), at=0.7, roll_rad=math.radians(90))
    rolled.run(0.5)
    x, y, z = (rolled.value(f"acc_{axis}") for axis in "xyz")
    assert math.hypot(x, y) == pytest.approx(9.81, rel=0.02)
    assert z == pytest.approx(0.0, abs=0.05)


def test_equal_seeds_give_equal_runs_to_the_last_bit(place: Place) -> None:
    def end_of_run() -> tuple[bytes, bytes]:
        robot = place(bend(), at=0.7, seed=5)
        robot.drive(1.0)
        robot.clamp(*ALL_JOINTS)
        for _ in range(300):
            robot.read()
        return robot.physics.state.array.tobytes(), robot.electronics.counts.tobytes()

    assert end_of_run() == end_of_run()


def test_another_robot_needs_other_numbers_only(
    place: Place, profile: Profile, small_profile: Profile
) -> None:
    small = chain_of(small_profile)
    assert small.nodes != chain_of(profile).nodes
    robot = place(straight(diameter_m=0.09), clamped=0.0, robot=small_profile)
    robot.clamp(*small.joints)
    robot.run(5.0)
    start = robot.middle
    robot.drive(1.0)
    robot.run(3.0)
    assert robot.middle - start > 0.15


def test_an_unclamped_robot_comes_to_rest_on_the_floor(place: Place) -> None:
    robot = place(straight(), at=2.5, clamped=0.0)
    robot.physics.state.velocity[:, 0] = 0.3
    start = robot.middle
    robot.run(2.0)
    # Coulomb: v^2 / (2 mu g), with the kinetic coefficient.
    assert robot.middle - start == pytest.approx(0.3**2 / (2 * 0.5 * 9.81), rel=0.1)
    assert abs(robot.physics.state.velocity).max() < 1e-6


@pytest.mark.parametrize(("tilt_deg", "slides"), [(20.0, False), (35.0, True)])
def test_an_unclamped_robot_slides_where_the_floor_is_steep(
    place: Place, tilt_deg: float, slides: bool
) -> None:
    # Kinetic friction of 0.5 holds up to atan(0.5) = 26.6 deg.
    shape = straight(tilt_rad=math.radians(tilt_deg), uphill_rad=0.0)
    robot = place(shape, at=2.5, clamped=0.0)
    start = robot.middle
    robot.run(0.5)
    assert (start - robot.middle > 0.05) is slides


def test_the_kernel_writes_the_quantities_that_every_physics_has() -> None:
    assert (len(PER_WHEEL), len(SINGLE)) == (columns.OUT_PER_WHEEL, columns.OUT_SINGLE)
