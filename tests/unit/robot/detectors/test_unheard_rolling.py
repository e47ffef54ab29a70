"""What wheels have rolled since they were heard: as far as it can be vouched for, no farther."""

from __future__ import annotations

from math import nan
from statistics import fmean

import pytest

from pirate_sm.core._engine.robot.robot_state import Flight
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.odometry_detector import Rolling
from pirate_sm.running.wiring import Order, prepare

SPEED = 0.1
HEARD_S = 10.0


@pytest.fixture(scope="module")
def begun() -> tuple[RobotSpec, EngineState]:
    loaded = prepare(Order("mitre_bend", backend="trace")).loaded
    state, _ = Engine(loaded.robot, loaded.program, nominal=False).start()
    return loaded.robot, state


class World:
    """All wheels drive alike; what differs is said."""

    def __init__(self, robot: RobotSpec, state: EngineState) -> None:
        self.robot, self.state = robot, state
        self.rolling = Rolling(robot)
        count = len(robot.wheels)
        self.speeds, self.heard_s = [SPEED] * count, [HEARD_S] * count
        self.shares = [1 / count] * count

    def look(self, now_s: float, duty: float = 1.0, sent: float | None = None) -> float:
        numbers, values = list(self.state.sensing.numbers), list(self.state.robot.values)
        heard_s = list(self.state.sensing.heard_s)
        for wheel, position in zip(self.robot.wheels, self.robot.wheel_boards, strict=True):
            numbers[wheel.speed] = self.speeds[wheel.place] / wheel.metres_per_rad
            values[wheel.slot] = duty
            heard_s[position] = self.heard_s[wheel.place]
        sensing = self.state.sensing._replace(
            numbers=tuple(numbers), heard_s=tuple(heard_s), shares=tuple(self.shares)
        )
        newest = [0.0 if sent is None else sent] * len(values)
        flight = None if sent is None else Flight(1, tuple(newest), "gate")
        robot = self.state.robot._replace(values=tuple(values), flight=flight)
        state = self.state._replace(sensing=sensing, robot=robot)
        return fmean(self.rolling.look(state, now_s))


@pytest.fixture
def world(begun: tuple[RobotSpec, EngineState]) -> World:
    return World(*begun)


@pytest.mark.parametrize("way", [1, -1])
def test_a_wheel_that_drives_has_gone_on(world: World, way: int) -> None:
    world.speeds = [way * SPEED] * 6

    assert world.look(HEARD_S) == 0.0
    assert world.look(HEARD_S + 0.3) == pytest.approx(way * 0.03)


def test_each_wheel_has_gone_on_for_its_own_age(world: World) -> None:
    world.heard_s[0] += 0.2

    assert world.look(HEARD_S + 0.3) == pytest.approx((5 * 0.03 + 0.01) / 6)


def test_what_is_told_to_stop_is_not_taken_any_farther(world: World) -> None:
    driving = world.look(HEARD_S + 0.2)

    assert world.look(HEARD_S + 0.5, duty=0.0) == pytest.approx(driving)


@pytest.mark.parametrize(("duty", "sent", "goes"), [(0.0, 1.0, 0), (1.0, 0.0, 0), (1.0, 1.0, 1)])
def test_a_wheel_goes_on_while_the_array_in_force_and_the_one_that_was_sent_drive_it(
    world: World, duty: float, sent: float, goes: int
) -> None:
    assert world.look(HEARD_S + 0.3, duty, sent) == pytest.approx(0.03 * goes)


def test_once_heard_after_the_stop_nothing_is_added(world: World) -> None:
    world.look(HEARD_S + 0.2)
    world.heard_s = [HEARD_S + 0.3] * 6

    assert world.look(HEARD_S + 0.5, duty=0.0) == 0.0


def test_wheels_that_have_not_been_driven_are_where_they_were(world: World) -> None:
    assert world.look(HEARD_S + 0.3, duty=0.0) == 0.0


@pytest.mark.parametrize(("freshest", "added_m"), [(0.0, 0.0), (0.04, 0.012), (-0.1, 0.0)])
def test_the_wheel_heard_last_shows_that_the_robot_is_slower(
    world: World, freshest: float, added_m: float
) -> None:
    world.heard_s[5], world.speeds[5] = HEARD_S + 0.3, freshest

    assert world.look(HEARD_S + 0.3) == pytest.approx(added_m * 5 / 6)


def test_a_wheel_whose_speed_is_forgotten_goes_as_fast_as_the_robot(world: World) -> None:
    world.heard_s = [HEARD_S + 0.6] * 6
    world.heard_s[2], world.speeds[2] = HEARD_S, nan

    assert world.look(HEARD_S + 0.6) == pytest.approx(0.06 / 6)


def test_the_wheel_heard_last_counts_wherever_it_is_in_the_robot(world: World) -> None:
    world.heard_s[0], world.speeds[0] = HEARD_S + 0.3, 0.04

    assert world.look(HEARD_S + 0.3) == pytest.approx(0.012 * 5 / 6)


def test_a_wheel_that_was_heard_last_without_a_speed_shows_nothing_of_the_robot(
    world: World,
) -> None:
    world.heard_s[5], world.speeds[5] = HEARD_S + 0.2, nan

    assert world.look(HEARD_S + 0.3) == pytest.approx((5 * 0.03 + 0.01) / 6)


def test_wheels_none_of_which_shares_in_the_odometry_go_no_farther(world: World) -> None:
    world.shares = [0.0] * 6

    assert world.look(HEARD_S + 0.3) == 0.0


def test_once_a_board_counts_as_silent_its_wheels_go_no_farther(world: World) -> None:
    world.look(HEARD_S + 0.9)

    assert world.look(HEARD_S + 5.0) == pytest.approx(SPEED * 1.0)


def test_what_was_rolled_is_not_taken_back_when_others_are_heard_to_stand(world: World) -> None:
    world.look(HEARD_S + 0.3)
    world.heard_s[1:], world.speeds[1:] = [HEARD_S + 0.4] * 5, [0.0] * 5

    assert world.look(HEARD_S + 0.5) == pytest.approx(0.03 / 6)
