"""Every way out of a run leads through here: the safe stop, and the end once its fate is known."""

from __future__ import annotations

from pirate_sm.engine.deadlines import has_come
from pirate_sm.engine.mission.program import Question
from pirate_sm.engine.robot import commands, robot_state
from pirate_sm.engine.state import Ending, EngineState, Setting
from pirate_sm.model.effects import Ask, CommandStatus, Effect, Ended, Outcome

SAFE_STOP_LIMIT_S = 2.0
"""How long the fate of the safe array is awaited before the run ends without knowing it."""


def withdraw(setting: Setting, state: EngineState, effects: list[Effect]) -> None:
    """A question that is still open is asked no more."""
    mission = state.mission
    if mission.begun and isinstance(setting.program.instructions[mission.pc], Question):
        effects.append(Ask("", ()))


def end(
    setting: Setting,
    state: EngineState,
    outcome: Outcome,
    message: str,
    name: str,
    now: float,
    effects: list[Effect],
) -> EngineState:
    """The safe stop is under way, or the run is over where nothing has ever been sent (rule 11)."""
    if state.mission.ending or state.mission.ended:
        return state
    withdraw(setting, state, effects)
    robot = state.robot
    if robot.motion is not None:
        motion = robot.motion
        command = setting.robot.commands[motion.command].name
        effects.append(CommandStatus(command, "failed", "the mission ended", motion.place))
        robot = commands.doubt_grip(setting.robot, robot)._replace(motion=None)
    if not robot.sent and _may_stay(setting, state):
        effects.append(Ended(outcome, message, name))
        return state._replace(mission=state.mission._replace(ended=True), robot=robot)
    doubted = commands.doubt(setting.robot, robot)
    if doubted.marks != state.robot.marks:
        effects.append(robot_state.state_change(setting.robot, doubted))
    robot = commands.stop(setting.robot, doubted, state.sensing, effects)
    ending = Ending(outcome, message, name, now + SAFE_STOP_LIMIT_S)
    return state._replace(robot=robot, mission=state.mission._replace(ending=ending))


def _may_stay(setting: Setting, state: EngineState) -> bool:
    """Whether a robot that has not been sent anything is left as it is.

    While its sensors are looked at, the safe array could actuate clamps that are not there; wheels
    that are declared to be driven are stopped all the same.
    """
    if setting.program.start_configuration == setting.robot.table.initial:
        return True
    return state.look is not None and not setting.robot.driven[state.robot.configuration]


def finish(state: EngineState, now: float, effects: list[Effect]) -> EngineState:
    """The run is over once the safe array's fate is known, or has been awaited long enough."""
    ending = state.mission.ending
    if ending is None:
        return state
    message = ending.message
    if state.robot.flight is not None:
        if not has_come(now, ending.give_up_s):
            return state
        message += " (the safe setpoints were not confirmed)"
    effects.append(Ended(ending.outcome, message, ending.end))
    return state._replace(mission=state.mission._replace(ended=True))
