from __future__ import annotations

import pytest

from pirate_sm.engine.robot.robot_state import DENIED, Mark
from pirate_sm.showing.left_state import left_state
from pirate_sm.wiring import Order, prepare


@pytest.fixture(scope="module")
def held():
    engine = prepare(Order("mitre_bend", backend="trace")).engine
    state, _ = engine.start(0.0)
    robot = engine.robot
    here = next(index for index, parts in enumerate(robot.held) if len(parts) == 2)
    return robot, state._replace(robot=state.robot._replace(configuration=here, marks=frozenset()))


def test_what_holds_and_what_is_not_confirmed_is_named(held) -> None:
    robot, state = held
    sent = (0.0,) * len(robot.slots)
    mark = Mark("part", min(robot.held[state.robot.configuration]), DENIED)
    doubted = state._replace(robot=state.robot._replace(marks=frozenset({mark})))

    said = left_state(robot, doubted, sent, nominal=False, heard=False)

    assert said.startswith("wheels set to zero, NOT confirmed by the robot; ")
    assert said.count("NOT confirmed by sensors") == 1
    assert said.count("(confirmed by sensors)") == 1


def test_wheels_that_may_turn_and_a_robot_that_was_left_alone_are_named(held) -> None:
    robot, state = held
    turning = (1.0,) * len(robot.slots)
    assert "may TURN" in left_state(robot, state, turning, nominal=True, heard=True)
    assert left_state(robot, state, (), nominal=True, heard=True).startswith("nothing was sent")
