"""Counts that the simulated boards send must read back, by the profile's own conversions."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from pirate_sm.core._model.robot.signals import TorqueOf
from pirate_sm.core.models import Profile
from pirate_sm.simulation.electronics import scale_of, sensors_of
from pirate_sm.simulation.physics import chain_of

from .conftest import Driver, bend, straight


@pytest.fixture
def silent(profile: Profile) -> Profile:
    """The robot with noiseless sensors."""
    noise = type(profile.simulation.noise)()
    simulation = profile.simulation.model_copy(update={"noise": noise})
    return profile.model_copy(update={"simulation": simulation})


def read(profile: Profile, robot: Driver) -> dict[str, float]:
    """Every signal in SI, as the engine would convert it."""
    counts = robot.read()
    scales = {
        channel.signal: scale_of(profile.conversions[channel.convert].scale)
        for board in profile.boards
        for channel in board.channels
        if channel.signal and channel.convert
    }
    return {name: counts[row] * scales[name] for name, row in robot.electronics.rows.items()}


def test_angles_torques_and_turns_read_back(
    profile: Profile, silent: Profile, place: Callable[..., Driver]
) -> None:
    robot = place(bend(), at=0.7, robot=silent)
    robot.clamp(1, 2, 3, 4)
    robot.drive(0.5)
    robot.run(1.0)
    seen = read(profile, robot)
    for joint in profile.body.joints:
        wheel = robot.chain.joint_index[joint.name]
        assert seen[joint.name] == pytest.approx(robot.values("bend")[wheel], abs=1e-3)
        assert joint.torque is not None
        torque = robot.values("bend_torque")[wheel]
        assert seen[joint.torque] == pytest.approx(torque, abs=5e-3)
    for index, each in enumerate(profile.body.wheels):
        assert seen[each.angle] == pytest.approx(robot.values("wheel")[index], abs=4e-3)


def test_the_wheel_current_reads_back_the_applied_torque(
    profile: Profile, silent: Profile, place: Callable[..., Driver]
) -> None:
    robot = place(straight(tilt_rad=math.pi / 2, uphill_rad=0.0), robot=silent)
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    robot.run(2.0)
    seen = read(profile, robot)
    torques = [d for d in profile.derived.values() if isinstance(d, TorqueOf)]
    slots = {slot.name: slot for slot in profile.slots}
    for torque in torques:
        wheel = slots[torque.slot].wheel
        assert wheel is not None
        applied = robot.values("drive")[robot.chain.wheel_index[wheel]]
        assert applied > 0.0
        assert seen[torque.torque_of] * scale_of(torque.scale) == pytest.approx(applied, abs=1e-3)


def test_a_stalled_bend_motor_draws_its_share_of_the_stall_current(
    profile: Profile, silent: Profile, place: Callable[..., Driver]
) -> None:
    robot = place(straight(), robot=silent)
    robot.clamp(1, 2, 3, 4, duty=0.5)
    robot.run(3.0)
    slot = next(slot for slot in profile.slots if slot.joint)
    stall = profile.motors[slot.motor].stall_current
    assert stall is not None
    currents = robot.values("bend_current")
    assert [currents[i] for i in (1, 2, 3, 4)] == pytest.approx([0.5] * 4, rel=0.05)


def test_currents_are_never_negative_and_noise_is_seeded(
    place: Callable[..., Driver],
) -> None:
    robot, twin, other = (place(straight(), seed=seed) for seed in (1, 1, 2))
    for each in (robot, twin, other):
        each.run(0.1)
    counts, same, others = robot.read(), twin.read(), other.read()
    rows = [row for name, row in robot.electronics.rows.items() if "current" in name]
    assert min(counts[row] for row in rows) >= 0.0
    assert counts == same
    assert counts != others


def test_every_robot_gets_its_own_channels(small_profile: Profile) -> None:
    small = sensors_of(small_profile, chain_of(small_profile))
    assert set(small.rows) == {
        channel.signal
        for board in small_profile.boards
        for channel in board.channels
        if channel.signal
    }
