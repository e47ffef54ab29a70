"""Compare the robot with its sensors: before its first command, and after its controller was away.

A robot whose controller was away is treated as another one until its sensors show the known one.
An echo has shown that the safe setpoints have arrived. It shows nothing about the robot: the
controller may belong to another one, or this one may have fallen. Everything that was confirmed is
declared, and compared with what the sensors show now. Until that is over no command begins.
"""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.core._engine.mission import flow
from pirate_sm.core._engine.mission.flow import end, meet
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot import commands, declared_states, robot_state
from pirate_sm.core._engine.robot.command_outcome import doubt_grip
from pirate_sm.core._engine.robot.declared_states import Before, LookResult
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import DECLARED, STOPPED, Mark, confirmed_parts
from pirate_sm.core._engine.safety import FoundFault
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._engine.unwatched import changed, dark_way, denied, unproven
from pirate_sm.core._model.events import EVIDENCE_ENDS, FaultReport
from pirate_sm.core._model.faults import BuiltInFault
from pirate_sm.core.effects import CommandStatus, Ended, Fault

_LOST = {
    fault.code
    for fault in (BuiltInFault.LINK_LOST, BuiltInFault.LINK_SILENT, BuiltInFault.LINK_MISMATCH)
}


def compare(moment: Moment, state: EngineState, look: declared_states.Look) -> EngineState:
    """Continue the comparison of declared states and sensors; a contradiction ends the run."""
    state, seen = _compare(moment, state, look)
    state = state._replace(look=seen.look)
    if seen.look is not None:
        return state
    if look.before is not None:
        return _decide(moment, state, look.before, seen)
    if seen.contradictions:
        return _refuse(moment, state, seen)
    for part in declared_states.parts_left_open(moment.robot, state.robot):
        moment.warn(f"the sensors do not show whether the {part} part holds")
    return state


def see_again(moment: Moment, state: EngineState) -> EngineState:
    """Confirm the parts again whose sensors were not known, once they show that these hold."""
    look = declared_states.seen_again(moment.robot, state.lapsed, state.robot)
    if look is None:
        return state._replace(lapsed=None)
    state, seen = _compare(moment, state, look)
    return state._replace(lapsed=seen.look and seen.look.uncontradicted())


def _compare(
    moment: Moment, state: EngineState, look: declared_states.Look
) -> tuple[EngineState, declared_states.LookResult]:
    """Return the result of a comparison, and the state without the marks that it confirms."""
    robot, body = moment.robot, state.robot
    numbers, diameter_m = state.sensing.numbers, moment.program.diameter_m
    strange = _changed_meanwhile(moment, state, look.before) if look.before else ()
    seen = declared_states.look(robot, look, body, numbers, diameter_m, moment.now_s, strange)
    if seen.confirmed:
        before = robot_state.state_change(robot, body)
        body = body._replace(marks=body.marks - seen.confirmed)
        state = state._replace(robot=body)
        change = robot_state.state_change(robot, body)
        if change != before:
            moment.emit(change)
    return state, seen


def _refuse(moment: Moment, state: EngineState, seen: declared_states.LookResult) -> EngineState:
    """End the run because the sensors contradict the declared states.

    No array was sent. The safe array is sent only if wheels turn, because it would actuate clamps
    that may not hold.
    """
    message = (
        f"the sensors contradict what is declared: {'; '.join(seen.contradictions)}. "
        "Say with --state REGION=STATE where the robot is"
    )
    moment.emit(Fault(declared_states.CODE, message, "stop"))
    cause = f"{declared_states.CODE}: {message}"
    if not seen.turning:
        moment.emit(Ended("fault", cause, ""))
        return state._replace(mission=state.mission._replace(ended=True))
    robot = state.robot._replace(sent=True)
    return end(moment, state._replace(robot=robot), "fault", cause)


# --- after the controller was away ------------------------------------------------------------


def begin_again(
    moment: Moment, before: EngineState, state: EngineState, report: FaultReport
) -> EngineState:
    """Hold the robot and begin to compare it with the one before, unless the fault ends the run.

    Args:
        moment: When it is, and what happens.
        before: The state before the report.
        state: The state in which the report has been handled as a fault.
        report: What the backend has reported.
    """
    mission, robot, away_s = state.mission, moment.robot, report.away_s
    if mission.ending:
        return state
    known = before.look.before if before.look is not None else None
    if known is not None:  # it was away again during the comparison
        known = known._replace(away_s=known.away_s + away_s)
    elif state.robot.sent:
        resumes = not (mission.diverting or mission.paused or mission.pause_wanted)
        known = Before(before.sensing, before.robot, away_s, resumes)
    if state.robot.sent and mission.diverting is None:
        state = _hold(moment, state, report.code)
    return state._replace(look=declared_states.begin(robot, state.robot, moment.now_s, known))


def _hold(moment: Moment, state: EngineState, code: str) -> EngineState:
    """Stop the wheels and all loops; a mission that runs pauses meanwhile.

    A command whose first array has no result yet has failed, and so has one of the operator. The
    mission gives its own again afterwards.
    """
    body, mission = state.robot, state.mission
    motion = None if mission.suspended else body.motion
    if motion is not None and (isnan(motion.accepted_s) or mission.paused):
        reason = f"interrupted by {code}"
        name = moment.robot.commands[motion.command].name
        moment.emit(CommandStatus(name, "failed", reason, motion.place))
        body = doubt_grip(moment.robot, body)._replace(motion=None)
        again = mission if mission.paused else mission._replace(begun=False)
        state = state._replace(robot=body, mission=again)
    if not mission.paused:
        state = flow.pause(moment, state)
    if state.robot.flight is None:  # its echo shows which array is in force now
        state = state._replace(robot=commands.stop(moment, state.robot, state.sensing))
    return state


def _changed_meanwhile(moment: Moment, state: EngineState, before: Before) -> tuple[str, ...]:
    """Return what the robot shows that it cannot have changed while its controller was away."""
    robot, body, numbers = moment.robot, before.body, state.sensing.numbers
    drove = any(body.latest[slot] for slot in robot.safe_zero)
    away_s = inf if isnan(before.away_s) else before.away_s
    last = state._replace(robot=body, sensing=before.sensing)
    moved = dark_way(robot, last, numbers, away_s if drove else 0.0).moved
    found = (moved,) if moved else ()
    if drove or body.motion is not None:
        return found
    held = confirmed_parts(robot, body)
    marks = frozenset(Mark("part", part, DECLARED) for part in held)
    return (*changed(robot, before.sensing.numbers, marks, numbers), *found)


def _decide(moment: Moment, state: EngineState, before: Before, result: LookResult) -> EngineState:
    """Return the state after the comparison: the mission continues, or a fault ends it."""
    robot, body, against = moment.robot, state.robot, result.contradictions
    if not against and before.resumes:
        lost = confirmed_parts(robot, before.body) - confirmed_parts(robot, body)
        told = "the sensors do not show that the {} part holds"
        against = tuple(told.format(robot.parts[part]) for part in sorted(lost))
    if against:
        body = commands.deny(moment, body, robot.held[body.configuration])
        message = f"after its controller was away, {'; '.join(against)}"
        found = FoundFault.built_in(BuiltInFault.STATE_CONTRADICTED, message)
        return meet(moment, state._replace(robot=body), found)
    if before.resumes and state.mission.paused:
        return flow.resume(moment, state, one_step=False)
    return state


def doubt_if_lost(moment: Moment, state: EngineState, code: str) -> EngineState:
    """Return the state after a fault: where the link is lost, nothing counts as confirmed."""
    older = moment.nominal or moment.alphabet < EVIDENCE_ENDS
    lost = code in _LOST and not (older or state.mission.ended)
    return doubt_all(moment, state, state) if lost else state


def doubt_all(moment: Moment, before: EngineState, state: EngineState) -> EngineState:
    """Return the state in which nothing counts as confirmed that was shown before.

    Wheels that are driven keep their state here, because whoever handles the fault stops them.
    """
    robot, body = moment.robot, state.robot
    driven, unshown = robot.driven[body.configuration], (DECLARED, STOPPED)
    again = body._replace(marks=unproven(robot, body))
    marks = {
        mark
        for mark in denied(robot, moment.program, before, again)
        if mark.kind == "part" or mark.which not in driven or mark.command not in unshown
    }
    marks |= {mark for mark in body.marks if mark.command == STOPPED}
    motion, mission = body.motion, state.mission
    if motion is not None:
        levelling = motion.levelling and motion.levelling._replace(felt=(), since_s=nan)
        origin = _uncounted(robot, motion.origin)
        motion = motion._replace(since_s=nan, settled_s=nan, origin=origin, levelling=levelling)
    body = body._replace(marks=frozenset(marks), motion=motion)
    moment.emit(robot_state.state_change(robot, body))
    return state.hearing(detector=None)._replace(
        robot=body,
        mission=mission._replace(origin=_uncounted(robot, mission.origin)),
        surveyed=state.surveyed._replace(forces=(), felt_s=-inf),
        word_until_s=inf,
    )


def _uncounted(robot: RobotSpec, origin: Numbers) -> Numbers:
    """Return the origin of changes, unknown for counters, which may have restarted at zero."""
    counted = {robot.body.roll, *(wheel.angle for wheel in robot.wheels)}
    return tuple(nan if at in counted else value for at, value in enumerate(origin))
