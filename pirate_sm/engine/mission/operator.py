"""What the operator may do, and why not: the one place that both the engine and a view ask."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pirate_sm.engine.mission import pausing
from pirate_sm.engine.mission.ending import end
from pirate_sm.engine.robot import commands, confirmation, robot_state
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import CommandStatus, Effect, Log
from pirate_sm.model.events import Abort, Answer, OperatorCommand, Skip

if TYPE_CHECKING:
    from pirate_sm.engine.engine import Engine


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
        return f"impossible: {confirmation.LOOKING}"
    if state.robot.motion is not None and not state.mission.suspended:
        return "impossible: another command is under way"
    if state.robot.flight is not None:
        return "impossible: setpoints are in flight"
    return robot_state.refusal(robot, state.robot, index)


def command(
    engine: Engine, state: EngineState, event: OperatorCommand, now: float, effects: list[Effect]
) -> EngineState:
    """Begin the command, or refuse it with the reason; a suspended command is ended by it."""
    index = engine.robot.table.command_index.get(event.command)
    if index is None:
        reason = "impossible: there is no such command"
    else:
        reason = why_not_command(engine.robot, state, index)
    if reason or index is None:
        effects.append(CommandStatus(event.command, "refused", reason))
        return state
    state = pausing.take_over(engine.robot, state, effects)
    robot = commands.begin(engine.robot, state.robot, state.sensing, index, None, "", effects)
    return state._replace(robot=robot)


def answer(
    engine: Engine, state: EngineState, event: Answer, now: float, effects: list[Effect]
) -> EngineState:
    """Note the answer, which the open question takes."""
    if state.mission.paused:
        effects.append(Log("warning", "no answer is taken while paused"))
        return state
    return state._replace(mission=state.mission._replace(answer=event.choice))


def skip(
    engine: Engine, state: EngineState, event: Skip, now: float, effects: list[Effect]
) -> EngineState:
    """Note that a wait or question is passed over."""
    if state.mission.paused:
        effects.append(Log("warning", "nothing is passed over while paused"))
        return state
    return state._replace(mission=state.mission._replace(skipped=event.trigger))


def abort(
    engine: Engine, state: EngineState, event: Abort, now: float, effects: list[Effect]
) -> EngineState:
    """End the run because the operator, or who drives the engine, wants it."""
    return end(engine.setting, state, "interrupted", event.reason, "", now, effects)
