from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pirate_sm.core._model.pipe_runs import Patch
from pirate_sm.core.models import Pipe, Profile, Straight, Turns
from pirate_sm.simulation.kinematic.world import World as KinematicWorld
from pirate_sm.simulation.mujoco.world import MujocoWorld
from pirate_sm.simulation.physics import MakePhysics
from pirate_sm.simulation.simulated_robot import SimulatedRobot
from pirate_sm.simulation.surroundings import gravity_of

CYCLE_S = 0.016
WORLDS = [KinematicWorld, MujocoWorld]


def pipe(**more: Any) -> Pipe:
    return Pipe(diameter=0.12, segments=(Straight(straight=3.0),), **more)


@pytest.fixture
def clamped(profile: Profile) -> Callable[..., SimulatedRobot]:
    def make(within: Pipe, physics: MakePhysics) -> SimulatedRobot:
        duties = {"bend_1": -0.5, "bend_2": 0.5, "bend_3": -0.5, "bend_4": 0.5}
        values = [duties.get(slot.name, 0.0) for slot in profile.slots]
        robot = SimulatedRobot(profile, within, physics, seed=1, start_values=values)
        robot.hold()
        return robot

    return make


def middle(robot: SimulatedRobot) -> float:
    return sum(robot.arcs_m) / len(robot.arcs_m)


def run(robot: SimulatedRobot, seconds: float) -> None:
    turn = robot.turns(False)[0]
    for cycle in range(round(seconds / CYCLE_S)):
        robot.step(cycle * CYCLE_S, turn)
        robot.meet_obstacles()


@given(
    tilt=st.floats(-1.5, 1.5), to=st.floats(-1.5, 1.5), uphill=st.floats(-6, 6),
    now_s=st.floats(0, 100),
)  # fmt: skip
def test_the_direction_against_gravity_stays_a_unit_vector(
    tilt: float, to: float, uphill: float, now_s: float
) -> None:
    assume(to != tilt)  # a pipe that turns to where it is, is refused
    turns = Turns.model_validate({"from": 10.0, "to": 20.0, "tilt": to})
    up = gravity_of(pipe(tilt=tilt, uphill=uphill, turns=turns))
    assert up is not None
    assert math.hypot(*up(now_s)) == pytest.approx(1.0)
    if now_s <= 10.0:
        assert up(now_s) == pipe(tilt=tilt, uphill=uphill).network().up
    if now_s >= 20.0:
        assert up(now_s) == pytest.approx(pipe(tilt=to, uphill=uphill).network().up)


def test_gravity_that_never_turns_is_not_asked_for() -> None:
    assert gravity_of(pipe(tilt=0.3)) is None


@pytest.mark.parametrize("physics", WORLDS)
def test_a_robot_begins_to_slide_when_gravity_has_turned(
    clamped: Callable[..., SimulatedRobot], physics: MakePhysics
) -> None:
    slippery = {"static": 0.04, "kinetic": 0.03}
    turns = Turns.model_validate({"from": 1.0, "to": 1.5, "tilt": math.pi / 2})
    robot = clamped(pipe(friction=slippery, turns=turns), physics)
    start = middle(robot)
    run(robot, 1.0)
    assert middle(robot) == pytest.approx(start, abs=1e-3)
    run(robot, 1.0)
    assert middle(robot) < start - 0.2


@pytest.mark.parametrize("physics", WORLDS)
def test_a_robot_slides_through_a_patch_and_not_before_it(
    clamped: Callable[..., SimulatedRobot], physics: MakePhysics
) -> None:
    ice = Patch.model_validate({"from": 0.5, "to": 3.0, "static": 0.02, "kinetic": 0.02})
    upright = {"tilt": math.pi / 2, "uphill": 0.0}
    held, sliding = (clamped(pipe(**upright, patches=patches), physics) for patches in ((), (ice,)))
    starts = [middle(held), middle(sliding)]
    for robot in (held, sliding):
        run(robot, 0.5)
    assert middle(held) == pytest.approx(starts[0], abs=2e-3)
    assert middle(sliding) < starts[1] - 0.1


@pytest.mark.parametrize("physics", WORLDS)
def test_a_wheel_that_has_left_a_patch_grips_again(
    clamped: Callable[..., SimulatedRobot], physics: MakePhysics
) -> None:
    ice = Patch.model_validate({"from": 1.45, "to": 3.0, "static": 0.02, "kinetic": 0.02})
    robot = clamped(pipe(tilt=math.pi / 2, uphill=0.0, patches=(ice,)), physics)
    run(robot, 4.0)
    fallen = middle(robot)
    run(robot, 2.0)
    assert middle(robot) == pytest.approx(fallen, abs=2e-3)
    assert min(robot.arcs_m) < 1.45
