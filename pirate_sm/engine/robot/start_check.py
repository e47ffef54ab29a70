"""The look at the sensors before the first command: what comes of it for the run."""

from __future__ import annotations

from pirate_sm.engine.mission.ending import end, withdraw
from pirate_sm.engine.robot import confirmation, robot_state
from pirate_sm.engine.state import EngineState, Setting
from pirate_sm.model.effects import Effect, Ended, Fault, Log


def go_on(
    setting: Setting, state: EngineState, look: confirmation.Look, now: float, effects: list[Effect]
) -> EngineState:
    """Compare what is declared with the sensors; a contradiction ends the run."""
    robot, body = setting.robot, state.robot
    numbers, diameter_m = state.sensing.numbers, setting.program.diameter_m
    seen = confirmation.look(robot, look, body, numbers, diameter_m, now)
    state = state._replace(look=seen.look)
    if seen.confirmed:
        before = robot_state.state_change(robot, body)
        body = body._replace(marks=body.marks - seen.confirmed)
        state = state._replace(robot=body)
        change = robot_state.state_change(robot, body)
        if change != before:
            effects.append(change)
    if seen.look is not None:
        return state
    if seen.contradictions:
        return _refuse(setting, state, seen, now, effects)
    for part in confirmation.parts_left_open(robot, body):
        effects.append(Log("warning", f"the sensors leave it open whether the {part} part holds"))
    return state


def _refuse(
    setting: Setting, state: EngineState, seen: confirmation.Seen, now: float, effects: list[Effect]
) -> EngineState:
    """End the run because the sensors contradict what is declared.

    Nothing has been sent. Only wheels that turn are stopped: the safe array would actuate clamps
    that may not be there.
    """
    message = (
        f"the sensors contradict what is declared: {'; '.join(seen.contradictions)}. "
        "Say with --state REGION=STATE where the robot is"
    )
    effects.append(Fault(confirmation.CODE, message, "stop"))
    cause = f"{confirmation.CODE}: {message}"
    if not seen.turning:
        withdraw(setting, state, effects)
        effects.append(Ended("fault", cause, ""))
        return state._replace(mission=state.mission._replace(ended=True))
    robot = state.robot._replace(sent=True)
    return end(setting, state._replace(robot=robot), "fault", cause, "", now, effects)
