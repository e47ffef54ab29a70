"""Derive what follows from an event: deadlines, completed commands, broken rules, next steps."""

from __future__ import annotations

from functools import partial
from math import inf, isnan

from pirate_sm.core._engine import safety, start_check
from pirate_sm.core._engine.mission.flow import (
    await_sight,
    divert,
    end,
    end_by_fault,
    finish,
    meet,
    pause_if_wanted,
    pause_until_seen,
)
from pirate_sm.core._engine.mission.interpreter import advance, without_requests
from pirate_sm.core._engine.mission.waiting import next_deadline
from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.robot import commands, declared_states, robot_state, setpoint_arrays
from pirate_sm.core._engine.robot.evidence import Evidence, proofs_after
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.safety import listen, unsettle
from pirate_sm.core._engine.sensing.environment import NOTHING_AROUND, differs, merged, survey
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._engine.sensing.signal_table import forget_stale
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core.effects import WakeAt


def settle(  # noqa: C901 - asked at every event, so most of it is asked here
    moment: Moment, before: EngineState, state: EngineState
) -> EngineState:
    """Return the state after everything that follows from an event at this moment.

    Args:
        moment: The time, the robot and program, and the effects so far.
        before: The state before the event.
        state: The state with the event in it.
    """
    due = has_come(moment.now_s, state.wake_at_s)
    if due:
        state = _housekeep(moment, state)
    if moment.now_s >= state.surveyed.due_s and not state.mission.ended:  # nothing follows the end
        state = _look_round(moment, state)
    judged = before
    if state.mission.ending is not None:
        state = finish(moment, state)
    elif not state.mission.ended:
        if state.looking is not None:
            state = start_check.compare(moment, state, state.looking)
        if state.lapsed is not None or declared_states.lapsed_in(state.robot.marks):
            state = start_check.see_again(moment, state)
        if state.robot.motion is not None and not state.mission.suspended:
            state = _watch_command(moment, state)
        # The next command is judged by the progress of the rules, so bring that up to date first.
        if state.robot is not before.robot:
            state = judged = watch_rules(moment, before, state)
        if not (state.mission.ending or state.mission.ended):
            state = _go_on(moment, state)
    if state.robot is not judged.robot:
        state = watch_rules(moment, judged, state)
    mission = state.mission
    if mission.answer is not None or mission.skipped is not None:
        state = state._replace(mission=without_requests(moment, state))
    robot, earlier = state.robot, before.robot
    moved = robot.marks is not earlier.marks or robot.configuration != earlier.configuration
    if moved and not moment.nominal:
        now = Evidence("sensor", moment.now_s, state.sensing.connection)
        state = state._replace(proofs=proofs_after(moment.robot, earlier, robot, state.proofs, now))
    changed = (
        state.robot is not before.robot
        or state.mission is not before.mission
        or state.word_until_s != before.word_until_s
        or state.look is not before.look
        or state.lapsed is not before.lapsed
    )
    if changed or moment.effects or due:
        state = _set_wake(moment, state)
    return state


def _go_on(moment: Moment, state: EngineState) -> EngineState:
    look = state.look
    if state.mission.diverting is not None and (look is None or look.before is not None):
        state = divert(moment, state)
    if look is None:  # no commands during a comparison
        if state.mission.sight_until_s < inf:
            state = await_sight(moment, state)
        if state.mission.pause_wanted:
            state = pause_if_wanted(moment, state)
        state = advance(moment, state)
    limit_s = moment.program.time_limit_s
    if limit_s < inf and has_come(state.mission.clock(moment.now_s), limit_s):
        message = f"the mission's time limit of {limit_s:g} s has passed"
        state = end(moment, state, "failed", message)
    if state.mission.pause_wanted:
        state = pause_if_wanted(moment, state)
    if state.robot.loops and not moment.nominal:  # a command of this step comes first
        robot = setpoint_arrays.stream(moment, state.robot, state.sensing)
        if robot is not state.robot:
            state = state._replace(robot=robot)
    return state


def _watch_command(moment: Moment, state: EngineState) -> EngineState:
    robot, finished = commands.watch(
        moment, state.robot, state.sensing, denied=moment.robot.denied_by(state.faults.raised)
    )
    if robot is not state.robot:
        state = state.moved(moment.robot, robot)
    return state.finished(finished)


def watch_rules(moment: Moment, before: EngineState, state: EngineState) -> EngineState:
    """Update the progress of the rules, and end a mission that breaks one.

    If a command of the operator breaks a rule, a warning is emitted and the mission continues. If
    only a clamp is missing whose sensors are not known now, it pauses until they show it again.
    """
    if not state.rules:
        return state
    old, new = before.robot, state.robot
    motion = new.motion or old.motion
    accepted = old.configuration != new.configuration
    if not accepted and old.marks == new.marks and old.values == new.values:
        return state
    diverting = state.mission.diverting is not None or state.look is not None
    if not accepted and diverting:
        return state
    name = moment.robot.commands[motion.command].name if motion is not None else None
    follow = partial(safety.follow, moment.program, moment.robot, state.rules)
    accepts = int(accepted), name if accepted else None
    places, broken = follow(new, *accepts)
    unseen = bool(broken) and not follow(declared_states.as_last_seen(new), *accepts)[1]
    if places != state.rules:
        state = state._replace(rules=places)
    # While a fault is being handled the mission breaks no rule: rules were checked before its last
    # command was sent, and its wheels are stopped before the handler begins. While sensors are
    # compared with states no command begins either.
    for rule in () if diverting else broken:
        if motion is not None and not motion.place:
            moment.warn(f"{name}, given by hand, violates {safety.said(rule)}")
        elif state.mission.ending or state.mission.ended:
            pass
        elif unseen:
            return pause_until_seen(moment, state)  # once, whatever rules are broken
        else:
            state = end_by_fault(moment, state, safety.RULE_BROKEN, safety.said(rule))
    return state


def _look_round(moment: Moment, state: EngineState) -> EngineState:
    """Survey the pipe around the robot, and report it if it has changed."""
    if moment.nominal:
        surveyed, found = state.surveyed._replace(due_s=inf), NOTHING_AROUND
    else:
        surveyed, found = survey(
            moment.robot,
            state.surveyed,
            state.robot,
            state.sensing.numbers,
            state.outside("detector"),
            state.faults.raised,
            moment.now_s,
        )
    if not has_come(moment.now_s, surveyed.outside_until_s):
        found = merged(found, surveyed.outside)
        surveyed = surveyed._replace(due_s=min(surveyed.due_s, surveyed.outside_until_s))
    if not differs(surveyed.reported, found):
        return state._replace(surveyed=surveyed)
    moment.emit(found)
    heard = state.hearing(segment=found.segment or None, joint=found.joint or None)
    return heard._replace(surveyed=surveyed._replace(reported=found))


def _housekeep(moment: Moment, state: EngineState) -> EngineState:
    """Forget signals that are too old, resend arrays that are due, and report silent boards."""
    if has_come(moment.now_s, state.word_until_s):
        state = state.hearing(detector=None)._replace(word_until_s=inf)
    robot = setpoint_arrays.resend(moment, state.robot, state.sensing)
    if robot is not state.robot:
        state = state._replace(robot=robot)
    if moment.nominal or not has_come(moment.now_s, listening_s(moment.robot, state.sensing)):
        return state
    sensing = forget_stale(moment.robot, state.sensing, moment.now_s)
    faults = state.faults
    if sensing.stale != state.sensing.stale:
        faults = unsettle(moment.robot, faults, sensing, state.obeyed_words(moment.robot))
    faults, found = listen(moment.robot, faults, sensing, moment.now_s, moment.alphabet)
    state = state._replace(sensing=sensing, faults=faults)
    for fault in found:
        state = meet(moment, start_check.doubt_if_lost(moment, state, fault.code), fault)
    return state


def _set_wake(moment: Moment, state: EngineState) -> EngineState:
    """Emit the next time at which something changes without an event, if it is another one."""
    if state.mission.ended:
        return state
    wake = _wake_s(moment, state)
    if wake == state.wake_at_s or isnan(wake):
        return state
    moment.emit(WakeAt(wake))
    return state._replace(wake_at_s=wake)


def _wake_s(moment: Moment, state: EngineState) -> float:
    """Return the next time at which something changes without an event."""
    due_s = min(deadline_s(moment, state), state.word_until_s)
    if moment.nominal:
        return min(due_s, state.surveyed.due_s)
    return min(due_s, listening_s(moment.robot, state.sensing))


def deadline_s(moment: Moment, state: EngineState) -> float:
    """Return the next deadline of the robot, its mission or the start check."""
    body = state.robot
    if state.mission.suspended:
        body = body._replace(motion=None)  # its deadline is frozen
    due_s = min(
        robot_state.next_deadline(moment.robot, body, moment.nominal), next_deadline(moment, state)
    )
    if state.looking is not None and not state.mission.ending:
        return min(due_s, state.looking.due_s)
    return due_s


def listening_s(robot: RobotSpec, sensing: Sensing) -> float:
    """Return when silent boards and stale signals are looked for again."""
    return sensing.checked_s + robot.link.listen_every_s
