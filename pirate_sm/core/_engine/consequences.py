"""Derive what follows from an event: deadlines, completed commands, broken rules, next steps."""

from __future__ import annotations

from math import inf, isnan

from pirate_sm.core._engine.control import sending
from pirate_sm.core._engine.deadlines import has_come
from pirate_sm.core._engine.evidence import Evidence
from pirate_sm.core._engine.mission import pausing
from pirate_sm.core._engine.mission.diverting import divert, meet
from pirate_sm.core._engine.mission.ending import end, finish
from pirate_sm.core._engine.mission.interpreter import advance, without_requests
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.resuming import reconnection
from pirate_sm.core._engine.robot import commands, confirmation, start_check
from pirate_sm.core._engine.robot.proofs import proofs_after
from pirate_sm.core._engine.safety.faults import listen, unsettle
from pirate_sm.core._engine.safety.rule_watch import watch
from pirate_sm.core._engine.sensing import surroundings
from pirate_sm.core._engine.sensing.conversion import forget_stale
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._engine.waking import listening_s, wake_s
from pirate_sm.core._model.effects import WakeAt


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
        state = surroundings.look_round(moment, state)
    judged = before
    if state.mission.ending is not None:
        state = finish(moment, state)
    elif not state.mission.ended:
        if state.looking is not None:
            state = start_check.go_on(moment, state, state.looking)
        if state.lapsed is not None or confirmation.lapsed_in(state.robot.marks):
            state = start_check.see_again(moment, state)
        if state.robot.motion is not None and not state.mission.suspended:
            state = _watch(moment, state)
        # The next command is judged by the progress of the rules, so bring that up to date first.
        if state.robot is not before.robot:
            state = judged = watch(moment, before, state)
        if not (state.mission.ending or state.mission.ended):
            state = _go_on(moment, state)
    if state.robot is not judged.robot:
        state = watch(moment, judged, state)
    mission = state.mission
    if mission.answer is not None or mission.skipped is not None:
        state = state._replace(mission=without_requests(moment, state))
    robot, earlier = state.robot, before.robot
    moved = robot.marks is not earlier.marks or robot.configuration != earlier.configuration
    if moved and not moment.nominal:
        now = Evidence("sensor", moment.now_s, state.connection)
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
            state = pausing.await_sight(moment, state)
        if state.mission.pause_wanted:
            state = pausing.begin_if_wanted(moment, state)
        state = advance(moment, state)
    limit_s = moment.program.time_limit_s
    if limit_s < inf and has_come(state.mission.clock(moment.now_s), limit_s):
        message = f"the mission's time limit of {limit_s:g} s has passed"
        state = end(moment, state, "failed", message)
    if state.mission.pause_wanted:
        state = pausing.begin_if_wanted(moment, state)
    if state.robot.loops and not moment.nominal:  # a command of this step comes first
        robot = sending.stream(moment, state.robot, state.sensing)
        if robot is not state.robot:
            state = state._replace(robot=robot)
    return state


def _watch(moment: Moment, state: EngineState) -> EngineState:
    robot, finished = commands.watch(
        moment, state.robot, state.sensing, denied=moment.robot.denied_by(state.faults.raised)
    )
    if robot is not state.robot:
        state = state.moved(moment.robot, robot)
    return state.finished(finished)


def _housekeep(moment: Moment, state: EngineState) -> EngineState:
    """Forget signals that are too old, resend arrays that are due, and report silent boards."""
    if has_come(moment.now_s, state.word_until_s):
        state = state.hearing(detector=None)._replace(word_until_s=inf)
    robot = sending.resend(moment, state.robot, state.sensing)
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
        state = meet(moment, reconnection.lose(moment, state, fault.code), fault)
    return state


def _set_wake(moment: Moment, state: EngineState) -> EngineState:
    """Emit the next time at which something changes without an event, if it is another one."""
    if state.mission.ended:
        return state
    wake = wake_s(moment, state)
    if wake == state.wake_at_s or isnan(wake):
        return state
    moment.emit(WakeAt(wake))
    return state._replace(wake_at_s=wake)
