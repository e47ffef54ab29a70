"""The simulated ruler tells how fast the robot moves along the pipe, ahead of it."""

from __future__ import annotations

from pathlib import Path
from statistics import mean, stdev

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import RulerSettings
from pirate_sm.robot.detectors.simple_detectors import Ruler
from pirate_sm.running.wiring import Order, prepare

NEWT = Path(__file__).resolve().parents[3] / "robots" / "newt"
SETTINGS = RulerSettings(signal="scale", every="100 ms", noise="0 mm/s")


class Robot:
    """Its wheels move along the pipe at a speed; the first one is the front."""

    def __init__(self, speed_m_s: float, *places_m: float) -> None:
        self.speed_m_s, self.places_m, self.now_s = speed_m_s, places_m, 0.0

    def places(self) -> tuple[float, list[float]]:
        return self.now_s, [place + self.speed_m_s * self.now_s for place in self.places_m]


def said(robot: Robot, settings: RulerSettings, times: int, seed: int = 1) -> list[float]:
    ruler, found = Ruler(settings, robot.places, seed), []
    for _ in range(times):
        robot.now_s = ruler.due_s
        for event in ruler.speak(robot.now_s):
            assert event.signal == "scale"
            found.append(event.value)
    return found


@pytest.mark.parametrize("speed", [0.09, -0.09, 0.0])
def test_it_says_the_speed_since_its_last_look(speed):
    assert said(Robot(speed, 0.5, 0.4, 0.3), SETTINGS, 4) == pytest.approx([speed] * 3)


def test_a_robot_of_one_wheel_heads_along_the_pipe():
    assert said(Robot(0.09, 0.5), SETTINGS, 2) == pytest.approx([0.09])


def test_ahead_is_where_the_front_wheel_is():
    assert said(Robot(0.09, 0.3, 0.4, 0.5), SETTINGS, 3) == pytest.approx([-0.09] * 2)


def test_it_says_nothing_before_anything_has_moved_on():
    robot = Robot(0.09, 0.5, 0.4)
    ruler = Ruler(SETTINGS, robot.places, 1)

    assert ruler.due_s == 0.0
    assert ruler.speak(0.0) == ()
    assert ruler.speak(0.0) == ()
    assert ruler.due_s == pytest.approx(0.1)


def test_its_noise_is_that_of_its_settings_and_the_seeds():
    noisy = SETTINGS.model_copy(update={"noise": 0.002})
    robots = [Robot(0.09, 0.5, 0.4) for _ in range(3)]

    one, same, other = (said(r, noisy, 500, s) for r, s in zip(robots, (1, 1, 2), strict=True))

    assert one == same != other
    assert mean(one) == pytest.approx(0.09, abs=0.0005)
    assert stdev(one) == pytest.approx(0.002, rel=0.2)


def test_a_robot_without_a_ruler_cannot_be_measured():
    with pytest.raises(UsageError, match="the profile of newt describes no ruler"):
        prepare(Order(str(NEWT / "patrol.yaml"), ruler=True))
