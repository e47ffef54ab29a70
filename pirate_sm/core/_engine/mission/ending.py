"""End a run: send the safe array, then end once it is confirmed or has timed out."""

from __future__ import annotations

from pirate_sm.core._engine.deadlines import has_come
from pirate_sm.core._engine.mission.program import Question
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import commands, robot_state
from pirate_sm.core._engine.robot.command_outcome import doubt_grip
from pirate_sm.core._engine.robot.unmet_conditions import unmet_conditions
from pirate_sm.core._engine.state import Ending, EngineState
from pirate_sm.core._model.effects import Ask, CommandStatus, Ended, Fault, Outcome
from pirate_sm.core._model.unmet_words import with_unmet

SAFE_STOP_LIMIT_S = 2.0
"""How long the run waits for the safe array's confirmation before it ends without it."""


def withdraw(moment: Moment, state: EngineState) -> None:
    """Withdraw the open question to the operator, if there is one."""
    mission = state.mission
    if mission.begun and isinstance(moment.program.instructions[mission.pc], Question):
        moment.emit(Ask("", ()))


def end_by_fault(
    moment: Moment, state: EngineState, code: str, message: str, of: tuple[str, ...] = ()
) -> EngineState:
    """Report the fault and end the run because of it."""
    moment.emit(Fault(code, message, "stop", of))
    return end(moment, state, "fault", f"{code}: {message}")


def end(
    moment: Moment, state: EngineState, outcome: Outcome, message: str, name: str = ""
) -> EngineState:
    """Send the safe array, or end the run at once if nothing was ever sent (rule 11).

    Args:
        moment: The time, the robot and program, and the effects so far.
        state: The state; if the run is ending already, only that is continued.
        outcome: How the run ends.
        message: Why, in one sentence.
        name: Name of the mission's end, if it has reached one.
    """
    if state.mission.ending or state.mission.ended:
        return state
    withdraw(moment, state)
    robot = state.robot
    if robot.motion is not None:
        motion = robot.motion
        command = moment.robot.commands[motion.command].name
        unmet = unmet_conditions(moment, robot, state.sensing)
        reason = with_unmet("the mission ended", unmet)
        moment.emit(CommandStatus(command, "failed", reason, motion.place, unmet))
        robot = doubt_grip(moment.robot, robot)._replace(motion=None)
    if not robot.sent and _may_stay(moment, state):
        moment.emit(Ended(outcome, message, name))
        return state._replace(mission=state.mission._replace(ended=True), robot=robot)
    doubted = commands.doubt(moment.robot, robot)
    if doubted.marks != state.robot.marks:
        moment.emit(robot_state.state_change(moment.robot, doubted))
    robot = commands.stop(moment, doubted, state.sensing)
    ending = Ending(outcome, message, name, moment.now_s + SAFE_STOP_LIMIT_S)
    return state._replace(robot=robot, mission=state.mission._replace(ending=ending))


def _may_stay(moment: Moment, state: EngineState) -> bool:
    """Return whether a robot to which nothing was sent may end without the safe array.

    During the start check the safe array could actuate clamps that do not hold. Wheels that are
    declared to be driven are stopped nevertheless.
    """
    if moment.program.start_configuration == moment.robot.table.initial:
        return True
    return state.look is not None and not moment.robot.driven[state.robot.configuration]


def finish(moment: Moment, state: EngineState) -> EngineState:
    """End the run once the safe array is confirmed, rejected or timed out."""
    ending = state.mission.ending
    if ending is None:
        return state
    message = ending.message
    if state.robot.flight is not None:
        if not has_come(moment.now_s, ending.give_up_s):
            return state
        message += " (the safe setpoints were not confirmed)"
    moment.emit(Ended(ending.outcome, message, ending.end))
    return state._replace(mission=state.mission._replace(ended=True))
