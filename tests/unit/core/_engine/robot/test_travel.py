from __future__ import annotations

from pathlib import Path
from typing import Literal

import pytest

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._loading.robot.loader import load_robot

ROOT = Path(__file__).resolve().parents[5]
ROBOTS = (ROOT / "hardware_profiles" / "pirate_ii", ROOT / "tests" / "robots" / "newt")


def setpoints(robot: RobotSpec, duty: float) -> list[float]:
    """All wheels driven forward by positive duty, as the robot's own actuation does."""
    values = [0.0] * len(robot.slots)
    for wheel in robot.wheels:
        values[wheel.slot] = duty if wheel.metres_per_rad > 0 else -duty
    return values


@pytest.mark.parametrize("folder", ROBOTS)
@pytest.mark.parametrize("polarity", ["normal", "mirrored"])
def test_the_setpoints_tell_the_direction_of_travel_in_either_polarity(
    folder: Path, polarity: Literal["normal", "mirrored"]
) -> None:
    robot = load_robot(folder).oriented(polarity)
    assert robot.travel(setpoints(robot, 0.5)) == 1
    assert robot.travel(setpoints(robot, -0.5)) == -1
    assert robot.travel(setpoints(robot, 0.0)) == 0


def test_equal_setpoints_travel_the_other_way_in_the_other_polarity() -> None:
    loaded = load_robot(ROBOTS[0])
    values = setpoints(loaded.normal, 1.0)
    assert (loaded.normal.travel(values), loaded.mirrored.travel(values)) == (1, -1)


def test_one_driven_part_is_enough_and_wheels_against_each_other_travel_nowhere() -> None:
    robot = load_robot(ROBOTS[0]).normal
    values = setpoints(robot, 1.0)
    for wheel in robot.wheels[:3]:
        values[wheel.slot] = 0.0
    assert robot.travel(values) == 1
    values[robot.wheels[0].slot] = -1.0
    assert robot.travel(values) == 0
