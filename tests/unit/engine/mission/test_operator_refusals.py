"""What a view shows of a command is what the engine does with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.mission.operator import why_not_command
from pirate_sm.loading.mission import load_mission
from pirate_sm.model.effects import CommandStatus
from pirate_sm.model.events import Abort, OperatorCommand, SubmitResult, Tick

ROOT = Path(__file__).parents[4]


@pytest.mark.parametrize("leading", [(), (0,), (0, 1)], ids=["at rest", "one", "two"])
def test_the_reason_told_beforehand_is_the_one_given_afterwards(leading):
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    state, _ = engine.start(paused=True)
    now = 0.0
    for index in leading:
        state, effects = engine.step(state, OperatorCommand(loaded.robot.commands[index].name), now)
        number = state.robot.flight.setpoint_id
        state, _ = engine.step(state, SubmitResult(number, "accepted"), now)
        now += 60.0
        state, _ = engine.step(state, Tick(), now)
    found = {}
    for index, command in enumerate(loaded.robot.commands):
        _, effects = engine.step(state, OperatorCommand(command.name), now)
        refused = [each.reason for each in effects if isinstance(each, CommandStatus)]
        found[command.name] = why_not_command(loaded.robot, state, index), refused[:1]

    assert all(
        told == ("" if given in ([""], []) else given[0]) for told, given in found.values()
    ), found
    assert any(told for told, _ in found.values())


def test_nothing_can_be_asked_for_while_the_mission_is_ending():
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    state, _ = engine.start(paused=True)
    state, _ = engine.step(state, Abort("enough"), 0.0)

    assert why_not_command(loaded.robot, state, 0) == "impossible: the mission is ending"
