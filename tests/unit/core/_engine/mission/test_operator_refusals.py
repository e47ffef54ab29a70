"""What a view shows of a command is what the engine does with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._model.events import Abort, OperatorCommand, SubmitResult, Tick
from pirate_sm.core.effects import CommandStatus

ROOT = Path(__file__).parents[5]


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
        found[command.name] = state.why_not_command(loaded.robot, index), refused[:1]

    assert all(
        told == ("" if given in ([""], []) else given[0]) for told, given in found.values()
    ), found
    assert any(told for told, _ in found.values())


def test_nothing_can_be_asked_for_while_the_mission_is_ending():
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    state, _ = engine.start(paused=True)
    state, _ = engine.step(state, Abort("enough"), 0.0)

    assert state.why_not_command(loaded.robot, 0) == "impossible: the mission is ending"


def driving(share: float = 1.0):
    """An engine with an operator's drive under way."""
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    state, _ = engine.start(paused=True)
    for now, command in enumerate(["ClampFront", "ClampRear", "DriveForward"]):
        request = OperatorCommand(command, share if command == "DriveForward" else 1.0)
        state, _ = engine.step(state, request, 60.0 * now)
        number = state.robot.flight.setpoint_id
        state, _ = engine.step(state, SubmitResult(number, "accepted"), 60.0 * now)
        if command != "DriveForward":
            state, _ = engine.step(state, Tick(), 60.0 * now + 59.0)
    return loaded.robot, engine, state


def test_a_brake_may_end_the_drive_that_the_operator_has_under_way():
    robot, engine, state = driving()
    brake = robot.table.command_index["Brake"]
    assert state.why_not_command(robot, brake) == "impossible: another command is under way"
    assert state.why_not_command(robot, brake, at_once=True) == ""
    _, refused = engine.step(state, OperatorCommand("Brake"), 120.0)
    assert [each.status for each in refused if isinstance(each, CommandStatus)] == ["refused"]

    stopped, effects = engine.step(state, OperatorCommand("Brake", at_once=True), 120.0)

    told = [(each.name, each.status) for each in effects if isinstance(each, CommandStatus)]
    assert told == [("DriveForward", "failed"), ("Brake", "sent")]
    assert all(stopped.robot.latest[slot] == 0 for slot in robot.safe_zero)


def test_no_other_command_ends_one_that_is_under_way():
    robot, _, state = driving()
    for name, index in robot.table.command_index.items():
        if name != "Brake":
            assert state.why_not_command(robot, index, at_once=True), name


def test_a_drive_at_a_share_of_its_speed_leaves_the_clamps_alone():
    robot, _, whole = driving()
    _, _, part = driving(0.4)

    for slot, (full, value) in enumerate(zip(whole.robot.values, part.robot.values, strict=True)):
        assert value == (0.4 * full if slot in robot.safe_zero else full)
    assert robot.travel(part.robot.values) == 1


def test_a_brake_does_not_end_a_command_while_nothing_drives():
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)
    state, _ = engine.start(paused=True)
    state, _ = engine.step(state, OperatorCommand("ClampFront"), 0.0)
    state, _ = engine.step(state, SubmitResult(state.robot.flight.setpoint_id, "accepted"), 0.0)
    brake = loaded.robot.table.command_index["Brake"]

    reason = state.why_not_command(loaded.robot, brake, at_once=True)
    assert reason == "impossible: another command is under way"
