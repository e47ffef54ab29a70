"""What the boards have said before the mission begins counts from its first array on."""

from __future__ import annotations

from math import radians

import pytest

from pirate_sm.core import library
from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import at_rest_in
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._model.events import SensorFrame
from pirate_sm.core.effects import Setpoints

KEPT_DEG = 30.0


def frame_with(robot: RobotSpec, name: str, value: float) -> SensorFrame:
    target = robot.vocabulary.numbers.index(name)
    for board in robot.boards.values():
        for place, number, scale in board.channels:
            if number == target:
                values = [0.0] * (max(place for place, *_ in board.channels) + 1)
                values[place] = value / scale
                return SensorFrame(board.id, tuple(values))
    raise AssertionError(f"no board tells {name}")


@pytest.mark.parametrize(("seen", "kept_deg"), [(True, KEPT_DEG), (False, 0.0)])
def test_an_angle_to_be_kept_is_the_measured_one_in_the_first_array(
    seen: bool, kept_deg: float
) -> None:
    loaded = load_mission(library.find_mission("enter_2d"))
    robot = loaded.robot
    body = at_rest_in(robot, loaded.program.start_configuration)
    frames = [frame_with(robot, "phi", radians(KEPT_DEG))] if seen else []

    _, effects = Engine(robot, loaded.program, nominal=False).start(0.0, frames, body=body)

    first = next(effect for effect in effects if isinstance(effect, Setpoints))
    turned = next(i for i, slot in enumerate(robot.slots) if slot.unit == "angle")
    assert first.values[turned] == pytest.approx(radians(kept_deg), abs=1e-3)
