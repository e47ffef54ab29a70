"""Give commands, track their arrays, and decide when they are done.

Pure functions over :class:`RobotState`. The chart moves when a command's first array has been
accepted. Until sensors show that the command is done, its new states are *unconfirmed*; an
unconfirmed clamp does not count as a clamp.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isnan, nan
from types import MappingProxyType
from typing import Literal

from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot import declared_states, levelling
from pirate_sm.core._engine.robot.command_outcome import (
    doubt_grip,
    marks_after,
    shown_done,
    touched,
    unmet_conditions,
    why_late,
    why_not_clamped,
    why_unmoved,
)
from pirate_sm.core._engine.robot.criteria import AngleSet
from pirate_sm.core._engine.robot.loops import Loops, ends_with_command
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DENIED,
    POSTURE,
    STOPPED,
    Finished,
    Levelling,
    Mark,
    Motion,
    RobotState,
    confirmed_parts,
    criteria_of,
    criterion_of,
    safe_values,
    state_change,
)
from pirate_sm.core._engine.robot.setpoint_arrays import (
    followed,
    is_done,
    looped_values,
    overtaken_result,
    pushed_harder,
    send,
    send_if_new,
    stage_array,
    stage_origin,
    switched_array,
    unknown_angle,
    unmoved_loops,
    without_loops,
)
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._model.events import SubmitResult
from pirate_sm.core._model.unmet import Unmet
from pirate_sm.core.effects import CommandStatus, Log

_NOTHING_DENIED: Mapping[int, str] = MappingProxyType({})


def begin(
    moment: Moment,
    state: RobotState,
    sensing: Sensing,
    command: int,
    timeout_s: float | None,
    place: str,
    share: float = 1.0,
) -> RobotState:
    """Send the command's first array; the chart moves when it is accepted.

    Call it only while :func:`refusal` is empty and no array is awaited. Wheels get this share.
    """
    spec = moment.robot.commands[command]
    target = moment.robot.table.follow(state.configuration, command)
    limit_s = spec.timeout_s if timeout_s is None else timeout_s
    if state.tried is not None and state.tried.command != command:
        state = state._replace(tried=None)
    posture = spec.posture(target)
    first = 0 if posture is None else POSTURE
    origin = stage_origin(state, first, sensing)
    motion = Motion(command, target, limit_s, place, stage=first, origin=origin, share=share)
    regions, stage = touched(moment.robot, state.configuration, state.marks, command)
    if posture is not None:
        stage = POSTURE
        motion = motion._replace(blind=unknown_angle(moment.robot, posture.writes, sensing))
    if memory := levelling.levelling_of(moment.robot, regions, target):
        angle = spec.done.asked(AngleSet)[0]  # the loader has checked it
        blind = motion.blind or levelling.why_not(moment.robot, state, sensing, angle)
        motion = motion._replace(levelling=memory, blind=blind)
    values, loops = stage_array(moment.robot, state, motion, sensing, regions, stage)
    moment.emit(CommandStatus(spec.name, "sent", "", place))
    return send(moment, state, motion, values, loops, "gate")


def resolve(
    moment: Moment, state: RobotState, result: SubmitResult
) -> tuple[RobotState, Finished | None]:
    """Apply the result of the array in flight; acceptance of a first array moves the chart.

    The result of an older array does not affect the command.
    """
    flight = state.flight
    if flight is None or result.setpoint_id != flight.setpoint_id:
        return overtaken_result(moment, state, result), None
    if result.status == "unknown":
        waiting = flight._replace(resend_at_s=moment.now_s + moment.robot.link.resend_after_s)
        return state._replace(flight=waiting), None
    if result.status == "accepted":
        state = state._replace(
            values=flight.values, seeking=flight.seeking, flight=None, overtaken=()
        )
        if (confirmed := declared_states.accepted(moment.robot, state)) is not state:
            state = confirmed
            moment.emit(state_change(moment.robot, state))
        if flight.purpose == "gate" and state.motion is not None:
            state = _accept(moment, state, state.motion)
        return state, None
    state = state._replace(flight=None)
    if flight.purpose == "gate" and state.motion is not None:
        state = state._replace(loops=flight.before)
        reason = f"setpoints {result.status}" + (f": {result.reason}" if result.reason else "")
        return fail(moment, state, reason), Finished(False, reason)
    return state, None


def watch(
    moment: Moment,
    state: RobotState,
    sensing: Sensing,
    *,
    denied: Mapping[int, str] = _NOTHING_DENIED,
) -> tuple[RobotState, Finished | None]:
    """Check the command under way against the signals and its deadline; run its position loops.

    While an array is awaited a command neither ends nor starts its next stage. Both could need a
    new array, and an array of unknown fate may be followed only by itself or by the safe stop.

    Args:
        moment: When it is, and what happens.
        state: The robot's state.
        sensing: What is known now.
        denied: Parts that do not hold, each with the message of the fault that shows it. A
            command that clamps one of them is not done.

    Returns:
        The new state, and the result of the command if it ended.
    """
    motion = state.motion
    if motion is None or isnan(motion.accepted_s):
        return state, None
    if moment.nominal:
        done_s = motion.accepted_s + moment.robot.commands[motion.command].nominal_s
        if state.awaited is None and has_come(moment.now_s, done_s):
            return _complete(moment, state, sensing, "nominal duration has passed")
        return state, None
    if motion.levelling is not None and motion.stage != POSTURE and not motion.blind:
        return _level(moment, state, motion, motion.levelling, sensing)
    return _reach(moment, state, motion, sensing, denied)


def fail(
    moment: Moment,
    state: RobotState,
    reason: str,
    unmet: tuple[Unmet, ...] = (),
    status: Literal["failed", "skipped"] = "failed",
) -> RobotState:
    """End the command under way as failed; its states stay unconfirmed.

    Its position loops stop; the loops of states continue. If the command had to reach a posture
    first, the joints of held parts may have moved, so these parts are unconfirmed until they are
    clamped again.

    Args:
        moment: When it is, and what happens.
        state: The robot's state.
        reason: Why it failed.
        unmet: The conditions that it still awaited.
        status: How it ended.
    """
    motion = state.motion
    if motion is None:
        return state
    name = moment.robot.commands[motion.command].name
    moment.emit(CommandStatus(name, status, reason, motion.place, unmet))
    return _end_motion(moment, doubt_grip(moment.robot, state)._replace(tried=motion))


def skip(moment: Moment, state: RobotState) -> RobotState:
    """End the command that the operator skips; its states stay unconfirmed."""
    return fail(moment, state, "by the operator", status="skipped")


def stop(moment: Moment, state: RobotState, sensing: Sensing) -> RobotState:
    """Stop all loops and send the safe array, even while another array is in flight."""
    values = safe_values(moment.robot, state, sensing.numbers)
    return send(moment, state, state.motion, values, (), "stop")


def switch_control(moment: Moment, state: RobotState, sensing: Sensing, control: int) -> RobotState:
    """Actuate the states in force, and those of later commands, by another control.

    To be called only where no command is under way and no array is awaited.
    """
    values, loops = switched_array(moment.robot, state, sensing, control)
    name = moment.robot.controls[control].name
    moment.emit(Log("info", f"control {name}" if name else "the usual control"))
    state = state._replace(control=control)
    if values == state.latest and loops == state.loops:
        return state
    return send(moment, state, None, values, loops, "loop")


def reassert(moment: Moment, state: RobotState, values: Numbers, loops: Loops) -> RobotState:
    """Restore the actuation that was in force before a pause, with its loops."""
    values = kept(state, values)
    if values == state.values and not loops:
        return state
    return send(moment, state, state.motion, values, loops, "loop")


def kept(state: RobotState, values: Numbers) -> Numbers:
    """Return setpoints to be restored; a NaN keeps the present value."""
    both = zip(values, state.values, strict=True)
    return tuple(now if isnan(value) else value for value, now in both)


def doubt(robot: RobotSpec, state: RobotState) -> RobotState:
    """Mark regions as unconfirmed whose wheels a pause or a fault has stopped."""
    driven = robot.driven[state.configuration]
    if not driven:
        return state
    stopped = {Mark("region", region, STOPPED) for region in driven}
    return state._replace(marks=state.marks | stopped)


def deny(moment: Moment, state: RobotState, parts: frozenset[int], why: int = DENIED) -> RobotState:
    """Mark the confirmed clamps of these parts as unconfirmed.

    Args:
        moment: The time, the robot and the effects so far.
        state: The state of the robot.
        parts: Indexes of the parts.
        why: ``DENIED`` or ``LAPSED``.
    """
    lost = confirmed_parts(moment.robot, state) & parts
    if lost:
        marks = state.marks | {Mark("part", part, why) for part in lost}
        state = state._replace(marks=marks)
        moment.emit(state_change(moment.robot, state))
    return state


# --- inside ---------------------------------------------------------------------------------


def _reach(
    moment: Moment, state: RobotState, motion: Motion, sensing: Sensing, denied: Mapping[int, str]
) -> tuple[RobotState, Finished | None]:
    """Check the criterion of the stage in force and the deadline; run the position loops."""
    state, free = followed(moment.robot, state, motion, sensing), state.awaited is None
    motion = state.motion or motion
    seekers, times_s = state.seekers, []
    why_not = why_not_clamped(state, motion, denied) if denied else ""
    for done, before_s in criteria_of(moment.robot, motion):
        since_s = nan
        if not why_not and is_done(moment.robot, state, motion, done, sensing):
            since_s = moment.now_s if isnan(before_s) else before_s
            held_s = done.must_hold_s(sensing.numbers, seekers)
            if free and has_come(moment.now_s, since_s + held_s):
                if unmoved := unmoved_loops(state, motion, done, sensing):
                    return _push_harder(moment, state, motion, sensing, unmoved)
                reason = shown_done(moment.robot, done, sensing.numbers, seekers)
                return _complete(moment, state, sensing, reason)
        times_s.append(before_s if isnan(before_s) and isnan(since_s) else since_s)
    if free and (motion.blind or has_come(moment.now_s, motion.deadline_s)):
        unmet = unmet_conditions(moment, state, sensing)
        reason = motion.blind or why_late(moment, state, motion, unmet, sensing)
        reason = f"{reason}: {why_not}" if why_not else reason
        return fail(moment, state, reason, unmet), Finished(False, reason)
    since_s, settled_s = (*times_s, nan)[:2]
    if since_s is not motion.since_s or settled_s is not motion.settled_s:
        state = state._replace(motion=motion._replace(since_s=since_s, settled_s=settled_s))
    if free and seekers:
        values = looped_values(moment.robot, state, sensing)
        state = send_if_new(moment, state, state.motion, values, state.loops)
    return state, None


def _push_harder(
    moment: Moment, state: RobotState, motion: Motion, sensing: Sensing, unmoved: Loops
) -> tuple[RobotState, Finished | None]:
    """Push joints that have not moved with all that their loops allow, or fail."""
    harder = state._replace(loops=pushed_harder(state, unmoved))
    if harder.loops == state.loops:
        reason = why_unmoved(moment.robot, unmoved)
        return fail(moment, state, reason), Finished(False, reason)
    values = looped_values(moment.robot, harder, sensing)
    motion = motion._replace(since_s=nan, settled_s=nan)
    return send_if_new(moment, harder, motion, values, harder.loops), None


def _level(
    moment: Moment, state: RobotState, motion: Motion, memory: Levelling, sensing: Sensing
) -> tuple[RobotState, Finished | None]:
    """Measure how the robot lies and turn the roll joint by that, until a part is level."""
    robot, now_s, free = moment.robot, moment.now_s, state.awaited is None
    done = criterion_of(robot, motion)
    angle = done.asked(AngleSet)[0]  # the loader has checked it
    resting = free and done.holds(sensing.numbers, state.values, state.loops)
    after = memory._replace(felt=())
    if resting:
        after = levelling.measured(robot, state, memory, sensing, now_s)
    if after != memory:
        motion = motion._replace(levelling=after)
        state = state._replace(motion=motion)
    found = levelling.judged(robot, state, after, sensing, angle, now_s) if resting else None
    if found is not None and found.done:
        return _complete(moment, state, sensing, found.done)
    if found is not None and not found.failed:
        turning = motion._replace(levelling=after._replace(felt=(), turns=after.turns + 1))
        values = list(state.latest)
        values[after.slot] = found.setpoint_rad
        return send_if_new(moment, state, turning, tuple(values), state.loops), None
    reason = found.failed if found is not None else ""
    unmet: tuple[Unmet, ...] = ()
    if free and has_come(now_s, motion.deadline_s):
        unmet = unmet_conditions(moment, state, sensing)
        late = why_late(moment, state, motion, unmet, sensing)
        reason = reason or (late if unmet else f"{late}: {levelling.NOT_MEASURED}")
    if reason:
        return fail(moment, state, reason, unmet), Finished(False, reason)
    return state, None


def _accept(moment: Moment, state: RobotState, motion: Motion) -> RobotState:
    """Move the chart, and mark what the command changes as unconfirmed."""
    name = moment.robot.commands[motion.command].name
    marks = marks_after(moment.robot, state.configuration, state.marks, motion.command)
    moment.emit(CommandStatus(name, "accepted", "", motion.place))
    state = state._replace(
        configuration=motion.target,
        marks=marks,
        motion=motion._replace(accepted_s=moment.now_s, deadline_s=moment.now_s + motion.timeout_s),
    )
    if moment.robot.commands[motion.command].proof == "sensor":
        moment.emit(state_change(moment.robot, state))
    return state


def _complete(
    moment: Moment, state: RobotState, sensing: Sensing, reason: str
) -> tuple[RobotState, Finished | None]:
    """Start the next stage, or end the command as done and confirm its changes."""
    motion = state.motion
    assert motion is not None  # callers have looked
    regions = tuple(
        sorted(m.which for m in state.marks if m.kind == "region" and m.command == motion.command)
    )
    target = moment.robot.table.configurations[state.configuration]
    stages = max((len(moment.robot.actuation[r][target[r]]) for r in regions), default=1)
    if motion.stage + 1 < stages:
        resting = state._replace(values=without_loops(state), flight=None)
        stage = motion.stage + 1
        values, loops = stage_array(moment.robot, resting, motion, sensing, regions, stage)
        if motion.stage == POSTURE or any(ends_with_command(each) for each in loops):
            later = motion._replace(stage=stage, origin=stage_origin(state, stage, sensing))
            later = later._replace(since_s=nan, settled_s=nan)
            return send_if_new(moment, state, later, values, loops), None
        state = send_if_new(moment, state, None, values, loops)
    else:
        state = _end_motion(moment, state)
    marks = frozenset(mark for mark in state.marks if mark.command != motion.command)
    state = state._replace(marks=marks, tried=None)
    name = moment.robot.commands[motion.command].name
    moment.emit(CommandStatus(name, "done", reason, motion.place))
    moment.emit(state_change(moment.robot, state))
    return state, Finished(True, reason)


def _end_motion(moment: Moment, state: RobotState) -> RobotState:
    """End the command under way; set the slots to zero that its position loops have driven.

    Loops of states continue. A command that was never accepted has driven nothing; the slots of
    its loops may hold a clamp and stay as they are.
    """
    values = without_loops(state)
    loops = tuple(each for each in state.loops if not ends_with_command(each))
    return send_if_new(moment, state, None, values, loops)
