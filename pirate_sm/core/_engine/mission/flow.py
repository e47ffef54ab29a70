"""The flow of a mission: move it to another instruction, pause and resume it, divert it, end it.

A pause stops the wheels, holds loops and deadlines, and continues all of it later. A fault is
logged; the mission goes to its handler, or ends (rule 10). At the end the safe array is sent, and
the run ends once it is confirmed or has timed out.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import inf, nan

from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission.program import STOP, Question
from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.robot import commands, declared_states, robot_state
from pirate_sm.core._engine.robot.command_outcome import doubt_grip, unmet_conditions
from pirate_sm.core._engine.robot.robot_state import Finished, RobotState
from pirate_sm.core._engine.safety import FoundFault
from pirate_sm.core._engine.state import BeforePause, Ending, EngineState, MissionState
from pirate_sm.core._model.events import EVIDENCE_ENDS, GoTo
from pirate_sm.core._model.faults import UNSEEN
from pirate_sm.core._model.unmet import with_unmet
from pirate_sm.core.effects import Ask, CommandStatus, Ended, Fault, Log, Outcome

SAFE_STOP_LIMIT_S = 2.0
"""How long the run waits for the safe array's confirmation before it ends without it."""

TAKEN_OVER = "the operator took over"


# --- another instruction ----------------------------------------------------------------------


def go(state: EngineState, target: int) -> EngineState:
    """Return the state with the mission at another instruction."""
    return state._replace(mission=moved(state.mission, target))


def moved(mission: MissionState, target: int) -> MissionState:
    """Return the mission at another instruction; a single step ends there with a pause."""
    mission = mission.at(target)
    if mission.one_step:
        return mission._replace(one_step=False, pause_wanted=True)
    return mission


def fail(moment: Moment, state: EngineState, cause: str, target: int) -> EngineState:
    """Continue at the failure's target; without a handler end the mission as failed (rule 4).

    A failure that the mission ignores does not replace the cause of an earlier one.
    """
    failed = moment.program.instructions[state.mission.pc]
    moment.take("on_failure", getattr(failed, "place", ""))
    passed_over = target == getattr(failed, "next", STOP)
    kept = state.mission.cause if passed_over else ""
    mission = state.mission._replace(cause=kept or cause)
    if target == STOP:
        state = state._replace(mission=mission)
        return end(moment, state, "failed", cause)
    _withdraw(moment, state)
    moment.warn(cause)
    return state._replace(mission=moved(mission, target))


# --- pauses -----------------------------------------------------------------------------------


def want_pause(state: EngineState) -> EngineState:
    """Return the state with a pause requested, which begins as soon as no array is awaited."""
    mission, look = state.mission, state.look
    if look is not None and look.before is not None:  # its pause becomes the operator's
        state = state._replace(look=look._replace(before=look.before._replace(resumes=False)))
    if mission.paused or mission.ending:
        return state._replace(mission=mission._replace(sight_until_s=inf))
    return state._replace(mission=mission._replace(pause_wanted=True, sight_until_s=inf))


def pause_at(moment: Moment, state: EngineState, place: str) -> EngineState:
    """Return the state with a pause requested by a breakpoint at the current instruction."""
    mission = state.mission
    phase = moment.program.phase_of[mission.pc]
    moment.emit(Log("info", f"breakpoint: {f'{phase} ' if phase else ''}pauses before {place}"))
    mission = mission._replace(pause_wanted=True, one_step=False, until="")
    return state._replace(mission=mission)


def pause_if_wanted(moment: Moment, state: EngineState) -> EngineState:
    """Begin a requested pause, unless an array is still awaited."""
    mission, body = state.mission, state.robot
    if not mission.pause_wanted or mission.ending or mission.diverting or body.awaited:
        return state
    return pause(moment, state)


def pause(moment: Moment, state: EngineState) -> EngineState:
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


def resume(moment: Moment, state: EngineState, *, one_step: bool) -> EngineState:
    """Resume the mission where it was; the pause shifts all deadlines by its length.

    The mission stays paused if the configuration has changed, because its earlier actuation must
    not be restored there. It also stays paused while a command of the operator is under way.
    """
    mission, body = state.mission, state.robot
    before = mission.before_pause
    if before is None:
        return state._replace(mission=mission._replace(pause_wanted=one_step))
    obstacle = state.why_not_resume() or _missing(moment, state)
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


def _missing(moment: Moment, state: EngineState) -> str:
    """Return the rules that a paused mission would break by resuming now; empty if none."""
    before, body = state.mission.before_pause, state.robot
    if before is None:
        return ""
    resumed = body._replace(values=commands.kept(body, before.values))
    here, there = (safety.broken(moment, state.rules, each) for each in (body, resumed))
    return "; ".join(safety.said(rule) for rule in there if rule not in here)


def pause_until_seen(moment: Moment, state: EngineState) -> EngineState:
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
    if state.why_not_resume():  # the operator has given a command meanwhile
        return state._replace(mission=mission._replace(sight_until_s=inf))
    missing, late = _missing(moment, state), has_come(moment.now_s, mission.sight_until_s)
    steps = bool(mission.since) and not mission.begun
    if late and missing:
        return end_by_fault(moment, state, safety.RULE_BROKEN, missing)
    if late and steps:
        state = state._replace(mission=_forget_actuation(mission, body))
    elif missing or (steps and declared_states.as_last_seen(body) != body):
        return state
    return resume(moment, state, one_step=mission.one_step)


def _forget_actuation(mission: MissionState, body: RobotState) -> MissionState:
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
    obstacle = state.why_not_go_to(moment.program, event.phase)
    if not obstacle and here != (event.states, event.unconfirmed):
        obstacle = "the robot's states have changed since they were checked"
    if obstacle:
        moment.warn(f"{event.phase} does not begin: {obstacle}")
        return state
    body, mission = state.robot, state.mission
    if body.motion is not None:
        body = commands.fail(moment, body, TAKEN_OVER)
    begin = moment.program.beginning(event.phase, body.control)
    assert begin is not None  # `why_not_go_to` has looked
    moment.emit(Log("info", f"handed back at {event.phase}"))
    mission = _running(moment, mission).at(begin)._replace(handling="", cause="", until=event.until)
    return state._replace(robot=body, mission=mission)


# --- faults -----------------------------------------------------------------------------------


def meet(moment: Moment, state: EngineState, fault: FoundFault) -> EngineState:
    """Log the fault and start its handler in the mission, or end the mission without one."""
    mission = state.mission
    if mission.ended:
        return state
    if moment.alphabet < EVIDENCE_ENDS:
        fault = fault._replace(of=())
    if fault.denies:
        state = state._replace(robot=commands.deny(moment, state.robot, fault.denies))
    if fault.code in UNSEEN:
        state = _lapse(moment, state, fault.of)
    if mission.ending:
        moment.emit(Fault(fault.code, fault.message, "stop", fault.of))
        return state
    things = moment.robot.owners.things_of(fault.of)
    handler = moment.program.handler(mission.pc, fault.code, things) if fault.catchable else None
    cause = f"{fault.code}: {fault.message}"
    if handler is not None and handler.go is None:
        moment.take("on_fault", handler.place, handler.code)
        moment.emit(Fault(fault.code, fault.message, "continue", fault.of))
        return state
    if handler is None or mission.handling or mission.diverting:
        return end_by_fault(moment, state, fault.code, fault.message, fault.of)
    moment.take("on_fault", handler.place, handler.code)
    moment.emit(Fault(fault.code, fault.message, handler.go_name, fault.of))
    mission = mission._replace(diverting=handler, stopped=False, cause=cause)
    return state._replace(mission=mission)


def _lapse(moment: Moment, state: EngineState, of: Iterable[str]) -> EngineState:
    """Take back that parts hold of which nothing is measured any more that shows it.

    Args:
        moment: The time, the robot and the effects so far.
        state: The state.
        of: Names of the boards, joints and wheels that are not measured.
    """
    if moment.nominal or moment.alphabet < EVIDENCE_ENDS:
        return state
    parts = moment.robot.unproved(of)
    body = commands.deny(moment, state.robot, parts, robot_state.LAPSED)
    return state._replace(robot=body) if body is not state.robot else state


def lapse_unheard(moment: Moment, state: EngineState) -> EngineState:
    """Do so for the boards whose signals are too old, before a command is judged."""
    stale, boards = state.sensing.stale, moment.robot.boards.values()
    if not stale:
        return state
    return _lapse(moment, state, (each.name for each in boards if each.position in stale))


def divert(moment: Moment, state: EngineState) -> EngineState:
    """Stop the wheels as soon as no array is awaited, then start the fault's handler."""
    mission, robot = state.mission, state.robot
    handler = mission.diverting
    if handler is None or handler.go is None or robot.awaited is not None:
        return state
    if not mission.stopped:
        _withdraw(moment, state)
        if robot.motion is not None:
            reason = f"interrupted by {mission.cause}"
            unmet = unmet_conditions(moment, robot, state.sensing)
            robot = commands.fail(moment, robot, with_unmet(reason, unmet), unmet)
        robot = commands.doubt(moment.robot, robot)
        moment.emit(robot_state.state_change(moment.robot, robot))
        robot = commands.stop(moment, robot, state.sensing)
        mission = mission._replace(stopped=True, begun=False)
        return state._replace(robot=robot, mission=mission)
    if state.look is not None:
        return state
    mission = _forget_actuation(mission, robot).at(handler.go)
    return state._replace(
        mission=mission._replace(diverting=None, stopped=False, handling=handler.go_name)
    )


# --- the end ----------------------------------------------------------------------------------


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
    _withdraw(moment, state)
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


def end_by_fault(
    moment: Moment, state: EngineState, code: str, message: str, of: tuple[str, ...] = ()
) -> EngineState:
    """Report the fault and end the run because of it."""
    moment.emit(Fault(code, message, "stop", of))
    return end(moment, state, "fault", f"{code}: {message}")


def _may_stay(moment: Moment, state: EngineState) -> bool:
    """Return whether a robot to which nothing was sent may end without the safe array.

    During the start check the safe array could actuate clamps that do not hold. Wheels that are
    declared to be driven are stopped nevertheless.
    """
    if moment.program.start_configuration == moment.robot.table.initial:
        return True
    return state.look is not None and not moment.robot.driven[state.robot.configuration]


def _withdraw(moment: Moment, state: EngineState) -> None:
    """Withdraw the open question to the operator, if there is one."""
    mission = state.mission
    if mission.begun and isinstance(moment.program.instructions[mission.pc], Question):
        moment.emit(Ask("", ()))


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
