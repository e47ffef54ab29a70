"""Pause and resume: stop the wheels, hold loops and deadlines, and continue all of it later."""

from __future__ import annotations

from math import inf, nan

from pirate_sm.core._engine.deadlines import has_come
from pirate_sm.core._engine.mission.ending import end_by_fault
from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import commands, confirmation, robot_state
from pirate_sm.core._engine.robot.robot_state import Finished, RobotState
from pirate_sm.core._engine.safety import rules
from pirate_sm.core._engine.state import BeforePause, EngineState, MissionState
from pirate_sm.core._model.effects import Log
from pirate_sm.core._model.events import GoTo

TAKEN_OVER = "the operator took over"


def wanted(state: EngineState) -> EngineState:
    """Return the state with a pause requested, which begins as soon as no array is awaited."""
    mission, look = state.mission, state.look
    if look is not None and look.before is not None:  # its pause becomes the operator's
        state = state._replace(look=look._replace(before=look.before._replace(resumes=False)))
    if mission.paused or mission.ending:
        return state._replace(mission=mission._replace(sight_until_s=inf))
    return state._replace(mission=mission._replace(pause_wanted=True, sight_until_s=inf))


def until_seen(moment: Moment, state: EngineState) -> EngineState:
    """Request a pause that ends once sensors show again that a part holds.

    If the operator has paused the mission and drives by hand, the wheels are stopped. A pause that
    the operator has asked for stays the operator's.
    """
    mission = state.mission
    if mission.paused and mission.sight_until_s == inf:
        robot = commands.doubt(moment.robot, state.robot)
        return state._replace(robot=commands.stop(moment, robot, state.sensing))
    if mission.pause_wanted or mission.sight_until_s < inf:
        return state
    limit_s = moment.robot.sight.within_s
    moment.warn(f"waits for sensors to show again that a part holds, for {limit_s:g} s at most")
    mission = mission._replace(pause_wanted=True, sight_until_s=moment.now_s + limit_s)
    return state._replace(mission=mission)


def await_sight(moment: Moment, state: EngineState) -> EngineState:
    """Resume a mission that waits for sight of a clamp, or end it if that takes too long.

    A step that has waited in vain begins with its wheels stopped, and is refused.
    """
    mission, body = state.mission, state.robot
    if not mission.paused or body.awaited is not None:
        return state
    if why_not_on(state):  # the operator has given a command meanwhile
        return state._replace(mission=mission._replace(sight_until_s=inf))
    missing, late = _missing(moment, state), has_come(moment.now_s, mission.sight_until_s)
    steps = bool(mission.since) and not mission.begun
    if late and missing:
        return end_by_fault(moment, state, rules.CODE, missing)
    if late and steps:
        state = state._replace(mission=forget(mission, body))
    elif missing or (steps and confirmation.as_last_seen(body) != body):
        return state
    return resume(moment, state, one_step=mission.one_step)


def begin_if_wanted(moment: Moment, state: EngineState) -> EngineState:
    """Begin a requested pause, unless an array is still awaited."""
    mission, body = state.mission, state.robot
    if not mission.pause_wanted or mission.ending or mission.diverting or body.awaited:
        return state
    return begin(moment, state)


def begin(moment: Moment, state: EngineState) -> EngineState:
    """Begin a pause now: stop the wheels and all loops, and freeze deadlines."""
    mission, body = state.mission, state.robot
    before = BeforePause(body.values, body.loops, body.configuration, body.motion is not None)
    if not robot_state.is_safe(moment.robot, body):
        doubted = commands.doubt(moment.robot, body)
        before = before._replace(doubts=doubted.marks - body.marks)
        if before.doubts:
            moment.emit(robot_state.state_change(moment.robot, doubted))
        body = commands.stop(moment, doubted, state.sensing)
    moment.emit(Log("info", "paused: wheels stopped, deadlines frozen"))
    paused = mission._replace(pause_wanted=False, paused_s=moment.now_s, before_pause=before)
    return state._replace(robot=body, mission=paused)


def forget(mission: MissionState, body: RobotState) -> MissionState:
    """Return the mission without the actuation that it would restore after its pause."""
    if mission.before_pause is None:
        return mission
    now = BeforePause(body.values, (), body.configuration, False)
    return mission._replace(before_pause=now)


def take_over(moment: Moment, state: EngineState) -> EngineState:
    """End the command that the pause has suspended, because the operator gives another one.

    When the mission resumes, its step has failed, and the robot is as the operator leaves it.
    """
    before, body = state.mission.before_pause, state.robot
    if before is None or not before.suspended:
        return state
    body = commands.fail(moment, body, TAKEN_OVER)
    untouched = (nan,) * len(body.values)
    mission = state.mission._replace(
        result=Finished(False, TAKEN_OVER),
        before_pause=BeforePause(untouched, (), before.configuration, suspended=False),
    )
    return state._replace(robot=body, mission=mission)


def go_to(moment: Moment, state: EngineState, event: GoTo) -> EngineState:
    """Resume at the beginning of a phase, if the robot's states have not changed since the request.

    The sender of the event has checked that the phase can run from these states, see
    :mod:`pirate_sm.checking.plans`.
    """
    here = robot_state.state_change(moment.robot, state.robot)
    obstacle = why_not_to(moment.program, state, event.phase)
    if not obstacle and here != (event.states, event.unconfirmed):
        obstacle = "the robot's states have changed since they were checked"
    if obstacle:
        moment.warn(f"{event.phase} does not begin: {obstacle}")
        return state
    body, mission = state.robot, state.mission
    if body.motion is not None:
        body = commands.fail(moment, body, TAKEN_OVER)
    begin = moment.program.beginning(event.phase, body.control)
    assert begin is not None  # why_not_to has looked
    moment.emit(Log("info", f"handed back at {event.phase}"))
    mission = _running(moment, mission).at(begin)._replace(handling="", cause="")
    return state._replace(robot=body, mission=mission)


def why_not_to(program: Program, state: EngineState, phase: str) -> str:
    """Return why the mission cannot resume at this phase now; empty if it can."""
    if program.enter(phase) is None:
        return "the mission has no such phase"
    if not state.mission.paused:
        return "pause the mission first"
    if state.look is not None:
        return confirmation.LOOKING
    if state.robot.awaited is not None:
        return "setpoints are in flight"
    if state.robot.motion is not None and not state.mission.suspended:
        return "a command is under way"
    return ""


def _missing(moment: Moment, state: EngineState) -> str:
    """Return the rules that a paused mission would break by resuming now; empty if none."""
    before, body = state.mission.before_pause, state.robot
    if before is None:
        return ""
    resumed = body._replace(values=commands.kept(body, before.values))
    here, there = (rules.broken(moment, state.rules, each) for each in (body, resumed))
    return "; ".join(rules.said(rule) for rule in there if rule not in here)


def why_not_on(state: EngineState) -> str:
    """Return why a paused mission cannot resume where it was; empty if it can or is not paused."""
    before, body = state.mission.before_pause, state.robot
    if before is None:
        return ""
    if state.look is not None and state.look.before is not None:
        return confirmation.LOOKING
    if body.awaited:
        return "setpoints are in flight"
    if body.configuration != before.configuration:
        return "the configuration has been changed"
    if body.motion is not None and not before.suspended:
        return "a command is under way"
    return ""


def resume(moment: Moment, state: EngineState, *, one_step: bool) -> EngineState:
    """Resume the mission where it was; the pause shifts all deadlines by its length.

    The mission stays paused if the configuration has changed, because its earlier actuation must
    not be restored there. It also stays paused while a command of the operator is under way.
    """
    mission, body = state.mission, state.robot
    before = mission.before_pause
    if before is None:
        return state._replace(mission=mission._replace(pause_wanted=one_step))
    obstacle = why_not_on(state) or _missing(moment, state)
    if obstacle:
        moment.warn(f"still paused: {obstacle}")
        return state
    length = moment.now_s - mission.paused_s
    if body.motion is not None:
        motion = body.motion._replace(
            accepted_s=body.motion.accepted_s + length,
            deadline_s=body.motion.deadline_s + length,
            since_s=nan,
            settled_s=nan,
        )
        body = body._replace(motion=motion)
    body = commands.reassert(moment, body, before.values, before.loops)
    if body.marks & before.doubts:
        body = body._replace(marks=body.marks - before.doubts)
        moment.emit(robot_state.state_change(moment.robot, body))
    moment.emit(Log("info", "resumed"))
    running = _running(moment, mission)._replace(one_step=one_step)
    return state._replace(robot=body, mission=running)


def _running(moment: Moment, mission: MissionState) -> MissionState:
    """Return a paused mission that runs again, with all its deadlines later by the pause."""
    offset_s = mission.offset_s + moment.now_s - mission.paused_s
    return mission._replace(paused_s=nan, offset_s=offset_s, before_pause=None, sight_until_s=inf)
