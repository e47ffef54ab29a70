from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from pirate_sm.simulation.surroundings import Obstacle, Obstacles

from .conftest import CYCLE_S, Driver, bend, straight

Place = Callable[..., Driver]


def in_the_way(robot: Driver, obstacles: list[Obstacle]) -> Obstacles:
    return Obstacles(robot.physics, robot.chain, robot.route, obstacles)


def run(robot: Driver, obstacles: Obstacles, seconds: float) -> list[str]:
    """Faults that were reported meanwhile."""
    faults = []
    for _ in range(round(seconds / CYCLE_S)):
        robot.physics.advance()
        robot.now_s += CYCLE_S
        fault = obstacles.step(robot.now_s, CYCLE_S)
        if fault is not None:
            faults.append(f"{fault.code}: {fault.message}")
    return faults


@pytest.mark.parametrize(("duty", "at", "place_m"), [(1.0, 1.0, 1.2), (-1.0, 2.0, 1.5)])
def test_an_obstacle_gives_way_after_it_has_been_pushed(
    place: Place, duty: float, at: float, place_m: float
) -> None:
    robot = place(straight(), at=at)
    obstacles = in_the_way(robot, [Obstacle(place_m, 0.0, 2.0)])
    robot.clamp(1, 2, 3, 4)
    robot.drive(duty)
    run(robot, obstacles, 2.2)
    stopped = robot.middle
    run(robot, obstacles, 0.5)
    assert robot.middle == pytest.approx(stopped, abs=2e-3)
    run(robot, obstacles, 4.0)
    assert abs(robot.middle - stopped) > 0.1


def test_an_obstacle_is_not_put_into_the_robot(place: Place) -> None:
    robot = place(straight(), at=1.0)
    obstacles = in_the_way(robot, [Obstacle(0.9)])
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    start = robot.middle
    run(robot, obstacles, 2.0)
    assert robot.middle - start > 0.15


def test_an_obstacle_comes_at_its_time(place: Place) -> None:
    robot = place(straight(), at=1.0)
    obstacles = in_the_way(robot, [Obstacle(1.15, from_s=0.6)])
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    run(robot, obstacles, 4.0)
    assert robot.arcs[0] < 1.15
    late = place(straight(), at=1.0)
    obstacles = in_the_way(late, [Obstacle(1.05, from_s=2.0)])
    late.clamp(1, 2, 3, 4)
    late.drive(1.0)
    run(late, obstacles, 1.9)
    assert late.arcs[0] > 1.1


def test_a_bend_out_of_the_plane_of_a_part_is_impassable(place: Place) -> None:
    robot = place(bend(), at=0.7, roll_rad=math.radians(90))
    obstacles = in_the_way(robot, [])
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    faults = run(robot, obstacles, 5.0)
    assert len(faults) == 1
    assert "pipe.impassable: bend 1 lies 90 deg out of the plane of wheel 1" in faults[0]
    assert robot.arcs[0] < 1.0


def test_a_bend_in_plane_is_no_fault(place: Place) -> None:
    robot = place(bend(), at=0.7)
    robot.clamp(1, 2, 3, 4)
    robot.drive(1.0)
    assert run(robot, in_the_way(robot, []), 5.0) == []


def test_a_robot_far_from_the_bend_meets_nothing_however_it_is_turned(place: Place) -> None:
    near, far, beyond = (place(bend(), at=at) for at in (0.75, 0.3, 1.6))
    windows = [in_the_way(robot, []).clear_m() for robot in (near, far, beyond)]

    assert windows[0] is None  # it may come near within a cycle
    assert windows[1] is not None
    assert windows[1][0] == -math.inf < windows[1][1] < 1.0
    assert windows[2] is not None
    assert windows[2][1] == math.inf > windows[2][0] > 1.0
