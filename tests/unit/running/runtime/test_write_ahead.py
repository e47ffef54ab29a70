"""In real time a command is on the disk before it is sent."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core.effects import Effect, Setpoints
from pirate_sm.core.engine import Engine
from pirate_sm.core.events import Event
from pirate_sm.core.loading import load_mission
from pirate_sm.robot.backends.trace import TraceBackend
from pirate_sm.running.runtime.pump import Pump
from pirate_sm.running.runtime.scripted_events import TriggerScript

ROOT = Path(__file__).parents[4]


class Robot(TraceBackend):
    """Keeps what is sent to it, in real time or not."""

    def __init__(self, course: list[str], *, real_time: bool) -> None:
        super().__init__()
        self._course = course
        self.real_time = real_time

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        self._course.append(f"sent {setpoint_id}")
        super().submit(setpoint_id, values)


class Tap:
    """Keeps which arrays were noted, and when it was to be on the disk."""

    stepwise = True
    due_s = 0.0

    def __init__(self, course: list[str]) -> None:
        self._course = course

    def start(
        self, seen: Sequence[Event], now_s: float, effects: Sequence[Effect], _: Any = None
    ) -> None:
        self._note(effects)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        self._note(effects)

    def secure(self) -> None:
        self._course.append("on the disk")

    def take_glide(self, glide: Any) -> None:
        """Ignore it."""

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Ignore it."""

    def _note(self, effects: Sequence[Effect]) -> None:
        arrays = [each for each in effects if isinstance(each, Setpoints)]
        self._course += [f"noted {each.setpoint_id}" for each in arrays]


def course_of(*, real_time: bool) -> list[str]:
    loaded = load_mission(ROOT / "tests/robots/newt/patrol.yaml")
    course: list[str] = []
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    companions = [TriggerScript(loaded.program)]
    robot, tap = Robot(course, real_time=real_time), Tap(course)
    pump = Pump(engine, robot, companions=companions, tap=tap)
    pump.start()
    while pump.ended is None:
        pump.take(*pump.wait())
    return course


def test_the_first_array_of_a_command_is_noted_and_on_the_disk_before_it_is_sent() -> None:
    course = course_of(real_time=True)

    at = course.index("on the disk")
    assert course[at - 1].startswith("noted")
    assert course[at + 1] == course[at - 1].replace("noted", "sent")


@pytest.mark.parametrize("real_time", [True, False])
def test_only_a_robot_that_moves_on_by_itself_is_worth_the_wait(real_time: bool) -> None:
    assert ("on the disk" in course_of(real_time=real_time)) == real_time
