"""End a run: the safe stop, and the end once its fate is known."""

from __future__ import annotations

from pirate_sm.engine.deadlines import has_come
from pirate_sm.engine.mission.program import Question
from pirate_sm.engine.moment import Moment
from pirate_sm.engine.robot import commands, robot_state
from pirate_sm.engine.state import Ending, EngineState
from pirate_sm.model.effects import Ask, CommandStatus, Ended, Fault, Outcome

SAFE_STOP_LIMIT_S = 2.0
"""How long the fate of the safe array is awaited before the run ends without knowing it."""


def withdraw(moment: Moment, state: EngineState) -> None:
    """Withdraw the question that is still open, if there is one."""
    mission = state.mission
    if mission.begun and isinstance(moment.program.instructions[mission.pc], Question):
        moment.emit(Ask("", ()))


def end_by_fault(moment: Moment, state: EngineState, code: str, message: str) -> EngineState:
    """Report the fault and end the run because of it."""
    moment.emit(Fault(code, message, "stop"))
    return end(moment, state, "fault", f"{code}: {message}")


def end(
    moment: Moment, state: EngineState, outcome: Outcome, message: str, name: str = ""
) -> EngineState:
    """Send the safe array, or end the run at once where nothing has ever been sent (rule 11).

    Args:
        moment: When it is, and what happens.
        state: The state; a run that is ending already goes on ending.
        outcome: How the run ends.
        message: Why, in one sentence.
        name: Of the mission's end, if it has come to one.
    """
    if state.mission.ending or state.mission.ended:
        return state
    withdraw(moment, state)
    robot = state.robot
    if robot.motion is not None:
        motion = robot.motion
        command = moment.robot.commands[motion.command].name
        moment.emit(CommandStatus(command, "failed", "the mission ended", motion.place))
        robot = commands.doubt_grip(moment.robot, robot)._replace(motion=None)
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
    """Whether a robot that has not been sent anything is left as it is.

    While its sensors are looked at, the safe array could actuate clamps that are not there; wheels
    that are declared to be driven are stopped all the same.
    """
    if moment.program.start_configuration == moment.robot.table.initial:
        return True
    return state.look is not None and not moment.robot.driven[state.robot.configuration]


def finish(moment: Moment, state: EngineState) -> EngineState:
    """End the run once the safe array's fate is known, or has been awaited long enough."""
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
