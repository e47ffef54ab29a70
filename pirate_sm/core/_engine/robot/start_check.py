"""Check the declared states against the sensors before the first command of a run."""

from __future__ import annotations

from pirate_sm.core._engine.mission.ending import end
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.resuming import reconnection
from pirate_sm.core._engine.robot import confirmation, robot_state
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model.effects import Ended, Fault


def go_on(moment: Moment, state: EngineState, look: confirmation.Look) -> EngineState:
    """Continue the comparison of declared states and sensors; a contradiction ends the run."""
    state, seen = _compare(moment, state, look)
    state = state._replace(look=seen.look)
    if seen.look is not None:
        return state
    if look.before is not None:
        return reconnection.decide(moment, state, look.before, seen)
    if seen.contradictions:
        return _refuse(moment, state, seen)
    for part in confirmation.parts_left_open(moment.robot, state.robot):
        moment.warn(f"the sensors do not show whether the {part} part holds")
    return state


def see_again(moment: Moment, state: EngineState) -> EngineState:
    """Confirm the parts again whose sensors were not known, once they show that these hold."""
    look = confirmation.seen_again(moment.robot, state.lapsed, state.robot)
    if look is None:
        return state._replace(lapsed=None)
    state, seen = _compare(moment, state, look)
    return state._replace(lapsed=seen.look)


def _compare(
    moment: Moment, state: EngineState, look: confirmation.Look
) -> tuple[EngineState, confirmation.LookResult]:
    """Return the result of a comparison, and the state without the marks that it confirms."""
    robot, body = moment.robot, state.robot
    numbers, diameter_m = state.sensing.numbers, moment.program.diameter_m
    strange = reconnection.strange(moment, state, look.before) if look.before else ()
    seen = confirmation.look(robot, look, body, numbers, diameter_m, moment.now_s, strange)
    if seen.confirmed:
        before = robot_state.state_change(robot, body)
        body = body._replace(marks=body.marks - seen.confirmed)
        state = state._replace(robot=body)
        change = robot_state.state_change(robot, body)
        if change != before:
            moment.emit(change)
    return state, seen


def _refuse(moment: Moment, state: EngineState, seen: confirmation.LookResult) -> EngineState:
    """End the run because the sensors contradict the declared states.

    No array was sent. The safe array is sent only if wheels turn, because it would actuate clamps
    that may not hold.
    """
    message = (
        f"the sensors contradict what is declared: {'; '.join(seen.contradictions)}. "
        "Say with --state REGION=STATE where the robot is"
    )
    moment.emit(Fault(confirmation.CODE, message, "stop"))
    cause = f"{confirmation.CODE}: {message}"
    if not seen.turning:
        moment.emit(Ended("fault", cause, ""))
        return state._replace(mission=state.mission._replace(ended=True))
    robot = state.robot._replace(sent=True)
    return end(moment, state._replace(robot=robot), "fault", cause)
