"""Decide which requests of the operator are possible, for the engine and for views."""

from __future__ import annotations

from typing import assert_never

from pirate_sm.core._engine.mission import pausing
from pirate_sm.core._engine.mission.diverting import lapse_unheard
from pirate_sm.core._engine.mission.ending import end
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import command_outcome, commands, confirmation
from pirate_sm.core._engine.robot.criteria import StoppedSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model.effects import CommandStatus, Log
from pirate_sm.core._model.events import (
    Abort,
    Answer,
    GoTo,
    Observation,
    OperatorCommand,
    Pause,
    Request,
    Resume,
    Skip,
    Step,
)


def why_not_command(
    robot: RobotSpec, state: EngineState, index: int, *, at_once: bool = False
) -> str:
    """Return why a command of the operator would be refused now; empty if it would be accepted.

    Args:
        robot: The robot.
        state: The engine's state.
        index: The command, as an index into the chart's commands.
        at_once: Whether it ends a drive that is under way, as in ``OperatorCommand``.
    """
    if state.mission.ended or state.mission.ending is not None:
        return "impossible: the mission is ending"
    if state.look is not None:
        return f"impossible: {confirmation.LOOKING}"
    motion, stops = state.robot.motion, isinstance(robot.commands[index].done, StoppedSpec)
    if motion is not None and not state.mission.suspended:
        drives = bool(robot.driven[motion.target])
        if not (at_once and stops and drives) or motion.place:
            return "impossible: another command is under way"
    if state.robot.awaited is not None:
        return "impossible: setpoints are in flight"
    return command_outcome.refusal(robot, state.robot, index)


def obey(moment: Moment, state: EngineState, request: Request) -> EngineState:
    """Carry out a request of the operator, or emit a warning that says why it is refused."""
    match request:
        case OperatorCommand():
            return _command(moment, state, request)
        case Observation():
            moment.emit(Log("info", f"{request.words} (operator)"))
            return state
        case Answer() | Skip() if state.mission.paused:
            answers = isinstance(request, Answer)
            what = "no answer is taken" if answers else "nothing is passed over"
            moment.warn(f"{what} while paused")
            return state
        case Answer(choice):
            return state._replace(mission=state.mission._replace(answer=choice))
        case Skip(trigger):
            return state._replace(mission=state.mission._replace(skipped=trigger))
        case Pause():
            return pausing.wanted(state)
        case Resume() | Step():
            return pausing.resume(moment, state, one_step=isinstance(request, Step))
        case GoTo():
            return pausing.go_to(moment, state, request)
        case Abort(reason):
            return end(moment, state, "interrupted", reason)
        case _:
            assert_never(request)


def _command(moment: Moment, state: EngineState, event: OperatorCommand) -> EngineState:
    """Begin the command or refuse it with a reason; a command suspended by a pause ends."""
    index = moment.robot.table.command_index.get(event.command)
    if index is None:
        reason = "impossible: there is no such command"
    else:
        state = lapse_unheard(moment, state)
        reason = why_not_command(moment.robot, state, index, at_once=event.at_once)
    if not 0 <= event.share <= 1:
        reason = reason or "impossible: the speed must be 0 to 100 %"
    if reason or index is None:
        moment.emit(CommandStatus(event.command, "refused", reason))
        return state
    state = pausing.take_over(moment, state)
    body = state.robot
    if body.motion is not None:
        body = commands.fail(moment, body, pausing.TAKEN_OVER)
    body = commands.begin(moment, body, state.sensing, index, None, "", share=event.share)
    return state._replace(robot=body)
