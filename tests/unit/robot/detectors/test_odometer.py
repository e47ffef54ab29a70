"""The way that odometry counts: by the median wheel of the part that holds the robot."""

from __future__ import annotations

from collections.abc import Callable
from math import nan

import pytest

from pirate_sm.core._engine.robot.robot_state import Flight
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.robot import RobotSpec
from pirate_sm.robot.detectors.odometry_detector import Odometer
from pirate_sm.running.wiring import Order, prepare

SPEED = 0.1
STEP_S = 0.05
FRONT, ALL = (0, 1, 2), (0, 1, 2, 3, 4, 5)


@pytest.fixture(scope="module", params=["mitre_bend", "mitre_bend_other_side"])
def begun(request: pytest.FixtureRequest) -> tuple[RobotSpec, EngineState]:
    loaded = prepare(Order(request.param, backend="trace")).loaded
    state, _ = Engine(loaded.robot, loaded.program, nominal=False).start()
    return loaded.robot, state


class World:
    """Wheels that roll, each with a speed of its own, heard every time or not."""

    def __init__(self, robot: RobotSpec, state: EngineState) -> None:
        self.robot, self.state = robot, state
        self.odometer = Odometer(robot)
        self.now_s = 0.0
        self.rolled = [0.0] * 6
        self.shown = [0.0] * 6
        self.heard_s = [0.0] * 6
        self.sent: float | None = None
        self.measures_speed = True
        self.idle: tuple[int, ...] = ()
        self.found: list[float] = []

    def run(
        self,
        for_s: float,
        speeds: Callable[[float], list[float]] = lambda _: [SPEED] * 6,
        *,
        duty: float = 1.0,
        mute: tuple[int, ...] = (),
        holding: tuple[int, ...] = FRONT,
        out: tuple[int, ...] = (),
    ) -> float:
        found = 0.0
        distance = self.state.sensing.distance._replace(out=frozenset(out))
        self.state = self.state._replace(sensing=self.state.sensing._replace(distance=distance))
        for _ in range(round(for_s / STEP_S)):
            self.now_s += STEP_S
            now_speeds = speeds(self.now_s) if duty or self.sent else [0.0] * 6
            found = self._look(now_speeds, duty, mute, holding)
            self.found.append(found)
        return found

    def _look(
        self, speeds: list[float], duty: float, mute: tuple[int, ...], holding: tuple[int, ...]
    ) -> float:
        sensing, body = self.state.sensing, self.state.robot
        numbers, values, heard_s = [*sensing.numbers], [*body.values], [*sensing.heard_s]
        for wheel, position in zip(self.robot.wheels, self.robot.wheel_boards, strict=True):
            self.rolled[wheel.place] += speeds[wheel.place] * STEP_S
            if wheel.place not in mute:
                self.shown[wheel.place] = self.rolled[wheel.place] / wheel.metres_per_rad
                self.heard_s[wheel.place] = self.now_s
            speed = speeds[wheel.place] if self.measures_speed else nan
            numbers[wheel.speed] = speed / wheel.metres_per_rad
            values[wheel.slot] = 0.0 if wheel.place in self.idle else duty
            heard_s[position] = self.heard_s[wheel.place]
        sensing = sensing._replace(
            numbers=tuple(numbers),
            heard_s=tuple(heard_s),
            angles=tuple(self.shown),
            shares=(1 / 6,) * 6,
        )
        newest = Flight(1, (self.sent,) * len(values), "gate") if self.sent is not None else None
        robot = body._replace(values=tuple(values), flight=newest)
        state = self.state._replace(sensing=sensing, robot=robot)
        return self.odometer.look(state, self.now_s, holding)


@pytest.fixture
def world(begun: tuple[RobotSpec, EngineState]) -> World:
    world = World(*begun)
    world.run(0.2, duty=0.0)
    return world


def test_wheels_that_roll_alike_are_the_way(world: World) -> None:
    assert world.run(5.0) == pytest.approx(5 * SPEED, abs=0.006)
    assert world.run(1.0, duty=0.0) == pytest.approx(5 * SPEED, abs=0.006)
    so_far = [min(max(0, step) * STEP_S, 5.0) * SPEED for step in range(-3, 121)]
    assert world.found == pytest.approx(so_far, abs=0.008)


def test_backward_counts_backward(world: World) -> None:
    assert world.run(2.0, lambda _: [-SPEED] * 6) == pytest.approx(-2 * SPEED, abs=0.006)


def test_a_wheel_that_slips_is_left_out_whichever_it_is(world: World) -> None:
    def slipping(now_s: float) -> list[float]:
        return [3 * SPEED if place == int(now_s / 2) % 3 else SPEED for place in range(6)]

    # The mean would be 400 mm too far. In the piece in which the slip changes, two wheels slip.
    assert world.run(6.0, slipping) == pytest.approx(6 * SPEED, abs=0.05)


def test_a_dead_wheel_is_left_out(world: World) -> None:
    dead = [SPEED, SPEED, 0.0, 0.0, SPEED, SPEED]
    assert world.run(5.0, lambda _: dead) == pytest.approx(5 * SPEED, abs=0.006)


def test_a_wheel_that_is_not_driven_counts_nothing(world: World) -> None:
    world.idle = (0, 1)
    assert world.run(5.0, lambda _: [0.0, 0.0, *[SPEED] * 4]) == pytest.approx(5 * SPEED, abs=0.006)


@pytest.mark.parametrize("dead", [FRONT, (0, 1)])
def test_wheels_that_the_engine_does_not_believe_count_nothing(
    world: World, dead: tuple[int, ...]
) -> None:
    speeds = [0.0 if place in dead else SPEED for place in range(6)]
    assert world.run(5.0, lambda _: speeds, out=dead) == pytest.approx(5 * SPEED, abs=0.006)


def test_the_wheels_of_the_other_part_count_only_where_none_of_the_holding_part_can(
    world: World,
) -> None:
    halves = [SPEED] * 3 + [2 * SPEED] * 3
    assert world.run(2.0, lambda _: halves) == pytest.approx(2 * SPEED, abs=0.006)
    assert world.run(2.0, lambda _: halves, holding=(3, 4, 5)) == pytest.approx(6 * SPEED, abs=0.02)


def test_what_rolls_while_no_wheel_is_driven_is_no_way(world: World) -> None:
    world.rolled = [0.05] * 6
    assert world.run(1.0, duty=0.0) == 0.0


def test_what_was_not_heard_while_driving_is_made_up_when_it_is(world: World) -> None:
    world.run(1.0)
    assert world.run(0.5, mute=ALL) == pytest.approx(1.5 * SPEED, abs=0.01)
    assert world.run(0.2) == pytest.approx(1.7 * SPEED, abs=0.01)
    world.run(0.3, mute=ALL)
    assert world.run(0.5, duty=0.0) == pytest.approx(2.0 * SPEED, abs=0.01)


def test_a_silent_wheel_does_not_hold_the_way_back(world: World) -> None:
    world.run(1.0)
    assert world.run(4.0, mute=(0, 1)) == pytest.approx(5 * SPEED, abs=0.03)
    assert world.run(1.0) == pytest.approx(6 * SPEED, abs=0.03)


def test_nothing_is_counted_of_a_wheel_without_a_value(world: World) -> None:
    world.shown = [nan] * 6
    assert world.run(1.0, mute=ALL) == 0.0


def test_a_wheel_whose_value_comes_back_counts_from_there(world: World) -> None:
    world.run(1.0)
    shown, world.shown = world.shown, [nan] * 6
    lost_m = 0.5 * SPEED
    assert world.run(0.5, mute=ALL) == pytest.approx(1.0 * SPEED, abs=0.01)
    world.shown = shown
    assert world.run(2.0) == pytest.approx(3.5 * SPEED - lost_m, abs=0.015)


def slowing(now_s: float) -> list[float]:
    """Wheels that are slower than when they were last heard, at 1.2 s of mission time."""
    return [SPEED if now_s < 1.21 else SPEED / 4] * 6


@pytest.mark.parametrize("heard", [True, False])
def test_how_far_wheels_rolled_until_the_stop_is_taken_from_their_next_report(
    world: World, heard: bool
) -> None:
    world.run(1.0, slowing)
    world.measures_speed = False  # what was rolled unheard is estimated by the last known speed
    world.run(0.4, slowing, mute=ALL)
    world.run(0.05, duty=0.0, mute=() if heard else ALL)
    for place in FRONT:  # until the part that holds stands; the other one stands already
        world.rolled[place] += 0.01

    way_m = SPEED + 0.4 * SPEED / 4 + 0.01
    assert world.run(0.2, duty=0.0) == pytest.approx(way_m, abs=0.006)
    world.rolled = [rolled + 0.05 for rolled in world.rolled]  # somebody pushes it
    assert world.run(0.5, duty=0.0) == pytest.approx(way_m, abs=0.006)
    assert world.run(1.0) == pytest.approx(way_m + SPEED, abs=0.012)


def test_a_silent_board_is_not_waited_for_after_a_stop(world: World) -> None:
    world.run(1.0)
    world.run(0.1, duty=0.0, mute=(5,))
    world.run(2.0, duty=0.0, mute=(5,))
    world.rolled = [rolled + 0.05 for rolled in world.rolled]

    assert world.run(0.2, duty=0.0, mute=(5,)) == pytest.approx(SPEED, abs=0.006)


@pytest.mark.parametrize(("in_force", "sent"), [(1.0, 0.0), (0.0, 1.0)])
def test_wheels_roll_while_the_array_in_force_or_the_newest_one_drives_them(
    world: World, in_force: float, sent: float
) -> None:
    world.run(1.0)
    world.run(1.0, duty=0.0)
    world.sent = sent
    assert world.run(2.0, duty=in_force) == pytest.approx(3 * SPEED, abs=0.012)


def test_the_second_stop_is_another_one(world: World) -> None:
    world.run(1.0)
    world.run(1.0, duty=0.0)
    world.run(1.0)
    world.measures_speed = False
    world.run(0.2, mute=ALL)
    world.run(0.1, duty=0.0, mute=ALL)

    assert world.run(0.2, duty=0.0) == pytest.approx(2.2 * SPEED, abs=0.012)


def test_wheels_that_are_heard_in_turns_have_all_reported_in_a_piece_of_the_way(
    world: World,
) -> None:
    world.measures_speed = False
    for turn in range(60):
        found = world.run(STEP_S, mute=tuple(place for place in ALL if turn % 6 != place))

    assert found == pytest.approx(60 * STEP_S * SPEED, rel=0.1)


def test_where_the_engine_believes_no_wheel_they_all_count(world: World) -> None:
    assert world.run(2.0, out=ALL) == pytest.approx(2 * SPEED, abs=0.006)
