"""What the operator may do, and why not: the one place that both the engine and a view ask."""

from __future__ import annotations

from typing import assert_never

from pirate_sm.engine import machine, pausing, robot_state, seeing
from pirate_sm.engine.ending import end
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.engine.state import EngineState, Setting
from pirate_sm.model.effects import CommandStatus, Effect, Log
from pirate_sm.model.events import (
    Abort,
    Answer,
    GoTo,
    OperatorCommand,
    Pause,
    Request,
    Resume,
    Skip,
    Step,
)


def why_not_command(robot: RobotSpec, state: EngineState, index: int) -> str:
    """Why a command of the operator would be refused now; empty: it would be taken.

    Args:
        robot: The robot.
        state: The engine's state.
        index: The command, as an index into the chart's commands.
    """
    if state.mission.ended or state.mission.ending is not None:
        return "impossible: the mission is ending"
    if state.look is not None:
        return f"impossible: {seeing.LOOKING}"
    if state.robot.motion is not None and not state.mission.suspended:
        return "impossible: another command is under way"
    if state.robot.flight is not None:
        return "impossible: setpoints are in flight"
    return robot_state.refusal(robot, state.robot, index)


def obey(
    setting: Setting, state: EngineState, request: Request, now: float, effects: list[Effect]
) -> EngineState:
    """Do what a person asks for, or say why not."""
    match request:
        case OperatorCommand():
            return _command(setting, state, request, effects)
        case Answer():
            return _answer(state, request, effects)
        case Skip():
            return _skip(state, request, effects)
        case Pause():
            return pausing.want(state)
        case Resume():
            return pausing.resume(setting.robot, state, now, False, effects)
        case Step():
            return pausing.resume(setting.robot, state, now, True, effects)
        case GoTo():
            return pausing.go_to(setting, state, request, now, effects)
        case Abort():
            return end(setting, state, "interrupted", request.reason, "", now, effects)
        case _:
            assert_never(request)


def _command(
    setting: Setting, state: EngineState, event: OperatorCommand, effects: list[Effect]
) -> EngineState:
    """Begin the command, or refuse it with the reason; a suspended command is ended by it."""
    index = setting.robot.table.command_index.get(event.command)
    if index is None:
        reason = "impossible: there is no such command"
    else:
        reason = why_not_command(setting.robot, state, index)
    if reason or index is None:
        effects.append(CommandStatus(event.command, "refused", reason))
        return state
    state = pausing.take_over(setting.robot, state, effects)
    robot = machine.begin(setting.robot, state.robot, state.sensing, index, None, "", effects)
    return state._replace(robot=robot)


def _answer(state: EngineState, event: Answer, effects: list[Effect]) -> EngineState:
    """Note the answer, which the open question takes."""
    if state.mission.paused:
        effects.append(Log("warning", "no answer is taken while paused"))
        return state
    return state._replace(mission=state.mission._replace(answer=event.choice))


def _skip(state: EngineState, event: Skip, effects: list[Effect]) -> EngineState:
    """Note that a wait or question is passed over."""
    if state.mission.paused:
        effects.append(Log("warning", "nothing is passed over while paused"))
        return state
    return state._replace(mission=state.mission._replace(skipped=event.trigger))
