"""The robot's state machines in motion: commands, arrays in flight, confirmation, position loops.

Pure functions over :class:`RobotState`. The chart moves when a command's first array has been
accepted; until the command is seen to be done its new states are *unconfirmed*, and an
unconfirmed clamp is no clamp.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isnan, nan
from types import MappingProxyType

from pirate_sm.engine.control.stages import (
    is_done,
    looped_values,
    stage_array,
    unknown_angle,
    why_late,
    without_loops,
)
from pirate_sm.engine.deadlines import has_come
from pirate_sm.engine.robot import confirmation
from pirate_sm.engine.robot.criteria import AcceptedSpec
from pirate_sm.engine.robot.done import Loop, must_hold_s, told
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import (
    DENIED,
    POSTURE,
    STOPPED,
    Finished,
    Flight,
    Mark,
    Motion,
    Numbers,
    Purpose,
    RobotState,
    confirmed_parts,
    criterion_of,
    marks_after,
    posture_of,
    safe_values,
    state_change,
    touched,
)
from pirate_sm.engine.sensing.conversion import Sensing
from pirate_sm.model.effects import CommandStatus, Effect, Setpoints
from pirate_sm.model.events import SubmitResult

_NOTHING_DENIED: Mapping[int, str] = MappingProxyType({})


def begin(
    robot: RobotSpec,
    state: RobotState,
    sensing: Sensing,
    command: int,
    timeout_s: float | None,
    place: str,
    effects: list[Effect],
) -> RobotState:
    """The command's first array has been sent; the chart waits for its acceptance.

    To be called only where :func:`refusal` is empty and no array is in flight.
    """
    spec = robot.commands[command]
    target = robot.table.follow(state.configuration, command)
    motion = Motion(command, target, spec.timeout_s if timeout_s is None else timeout_s, place)
    posture = spec.posture(target)
    regions, stage = touched(robot, state.configuration, state.marks, command)
    if posture is not None:
        stage, blind = POSTURE, unknown_angle(robot, posture.writes, sensing)
        motion = motion._replace(stage=POSTURE, blind=blind)
    values, loops = stage_array(robot, state, motion, sensing, regions, stage)
    effects.append(CommandStatus(spec.name, "sent", "", place))
    return _send(state, motion, values, loops, "gate", effects)


def resolve(
    robot: RobotSpec,
    state: RobotState,
    result: SubmitResult,
    now: float,
    effects: list[Effect],
) -> tuple[RobotState, Finished | None]:
    """The array in flight has met its fate; a command's first array has moved the chart.

    A result for another array than the one in flight changes nothing: it was superseded.
    """
    flight = state.flight
    if flight is None or result.setpoint_id != flight.setpoint_id:
        return state, None
    if result.status == "unknown":
        waiting = flight._replace(resend_at_s=now + robot.link.resend_after_s)
        return state._replace(flight=waiting), None
    if result.status == "accepted":
        state = state._replace(values=flight.values, seeking=flight.seeking, flight=None)
        if (confirmed := confirmation.accepted(robot, state)) is not state:
            state = confirmed
            effects.append(state_change(robot, state))
        if flight.purpose == "gate" and state.motion is not None:
            state = _accept(robot, state, state.motion, now, effects)
        return state, None
    state = state._replace(flight=None)
    if flight.purpose == "gate" and state.motion is not None:
        reason = f"setpoints {result.status}" + (f": {result.reason}" if result.reason else "")
        return fail(robot, state, reason, effects), Finished(False, reason)
    return state, None


def resend(state: RobotState, now: float, effects: list[Effect]) -> RobotState:
    """An array of unknown fate has been sent again, under its own id, when that was due."""
    flight = state.flight
    if flight is None or not has_come(now, flight.resend_at_s):
        return state
    effects.append(Setpoints(flight.setpoint_id, flight.values))
    return state._replace(flight=flight._replace(tries=flight.tries + 1, resend_at_s=inf))


def watch(
    robot: RobotSpec,
    state: RobotState,
    sensing: Sensing,
    now: float,
    nominal: bool,
    effects: list[Effect],
    *,
    denied: Mapping[int, str] = _NOTHING_DENIED,
) -> tuple[RobotState, Finished | None]:
    """The command under way has been held against the signals and its deadline.

    While an array is in flight a command neither ends nor goes on to its next stage: that could
    take a new array, and after one of unknown fate only the same one again or the safe stop may
    follow.

    Args:
        robot: The robot.
        state: Its state.
        sensing: What is known now.
        now: Time in seconds.
        nominal: Take the command as done after its nominal duration instead of by signals.
        effects: Taken along and added to.
        denied: Parts that do not hold, and the words of the fault that shows it. A command that
            clamps one is not done.

    Returns:
        The new state, and how the command ended if it did.
    """
    motion = state.motion
    if motion is None or isnan(motion.accepted_s):
        return state, None
    spec = robot.commands[motion.command]
    free = state.flight is None
    if nominal:
        if free and has_come(now, motion.accepted_s + spec.nominal_s):
            return _complete(robot, state, sensing, "nominal duration has passed", effects)
        return state, None
    since_s, done = motion.since_s, criterion_of(robot, motion)
    why_not = _why_not_clamped(state, motion, denied) if denied else ""
    if not why_not and is_done(robot, state, motion, done, sensing):
        since_s = now if isnan(since_s) else since_s
        held_s = must_hold_s(done, sensing.numbers, state.loops)
        if free and has_come(now, since_s + held_s):
            reason = told(robot, done, sensing.numbers, state.loops)
            return _complete(robot, state, sensing, reason, effects)
    elif not isnan(since_s):
        since_s = nan
    if free and (motion.blind or has_come(now, motion.deadline_s)):
        reason = motion.blind or why_late(robot, state, motion, sensing)
        reason = f"{reason}: {why_not}" if why_not else reason
        return fail(robot, state, reason, effects), Finished(False, reason)
    if since_s is not motion.since_s:
        state = state._replace(motion=motion._replace(since_s=since_s))
    if free and state.loops:
        values = looped_values(robot, state, sensing)
        state = _send_if_new(state, state.motion, values, state.loops, effects)
    return state, None


def fail(robot: RobotSpec, state: RobotState, reason: str, effects: list[Effect]) -> RobotState:
    """The command under way is over without being done; its states stay unconfirmed.

    Its position loops stop where they are. Where it was to take a posture first, how the held
    parts hold now has not been seen: they are unconfirmed until they are clamped again.
    """
    motion = state.motion
    if motion is None:
        return state
    name = robot.commands[motion.command].name
    effects.append(CommandStatus(name, "failed", reason, motion.place))
    return _end_motion(doubt_grip(robot, state), effects)


def skip(robot: RobotSpec, state: RobotState, effects: list[Effect]) -> RobotState:
    """The operator has passed over the command under way; its states stay unconfirmed."""
    motion = state.motion
    if motion is None:
        return state
    name = robot.commands[motion.command].name
    effects.append(CommandStatus(name, "skipped", "by the operator", motion.place))
    return _end_motion(doubt_grip(robot, state), effects)


def doubt_grip(robot: RobotSpec, state: RobotState) -> RobotState:
    """Mark the held parts as unconfirmed if the command under way has moved their joints.

    It has where its first array, that of a posture, was accepted.
    """
    motion = state.motion
    if motion is None or isnan(motion.accepted_s):
        return state
    if posture_of(robot, motion) is None:
        return state
    marks = {Mark("part", part, DENIED) for part in robot.held[state.configuration]}
    return state._replace(marks=state.marks | marks)


def stop(
    robot: RobotSpec, state: RobotState, sensing: Sensing, effects: list[Effect]
) -> RobotState:
    """The safe array has been sent, whatever else was in flight."""
    values = safe_values(robot, state, sensing.numbers)
    return _send(state, state.motion, values, (), "stop", effects)


def reassert(
    state: RobotState, values: Numbers, loops: tuple[Loop, ...], effects: list[Effect]
) -> RobotState:
    """Send an actuation again that was in force before a pause; NaN keeps the present value."""
    kept = tuple(
        now if isnan(value) else value for value, now in zip(values, state.values, strict=True)
    )
    if kept == state.values and not loops:
        return state
    return _send(state, state.motion, kept, loops, "loop", effects)


def doubt(robot: RobotSpec, state: RobotState) -> RobotState:
    """Mark the regions whose wheels are stopped from outside their states as unconfirmed."""
    driven = robot.driven[state.configuration]
    if not driven:
        return state
    stopped = {Mark("region", region, STOPPED) for region in driven}
    return state._replace(marks=state.marks | stopped)


def deny(
    robot: RobotSpec, state: RobotState, parts: frozenset[int], effects: list[Effect]
) -> RobotState:
    """Mark the clamps of these parts as unconfirmed where they have been confirmed."""
    lost = confirmed_parts(robot, state) & parts
    if lost:
        marks = state.marks | {Mark("part", part, DENIED) for part in lost}
        state = state._replace(marks=marks)
        effects.append(state_change(robot, state))
    return state


# --- inside ---------------------------------------------------------------------------------


def _why_not_clamped(state: RobotState, motion: Motion, denied: Mapping[int, str]) -> str:
    """Return why a part that the command under way is to clamp does not hold; else empty."""
    own = [mark for mark in sorted(state.marks) if mark.command == motion.command]
    return next((denied[m.which] for m in own if m.kind == "part" and m.which in denied), "")


def _send(
    state: RobotState,
    motion: Motion | None,
    values: Numbers,
    loops: tuple[Loop, ...],
    purpose: Purpose,
    effects: list[Effect],
) -> RobotState:
    effects.append(Setpoints(state.next_id, values))
    seeking = frozenset([loop.slot for loop in loops])
    flight = Flight(state.next_id, values, purpose, seeking=seeking)
    return state._replace(
        next_id=state.next_id + 1, flight=flight, motion=motion, loops=loops, sent=True
    )


def _accept(
    robot: RobotSpec, state: RobotState, motion: Motion, now: float, effects: list[Effect]
) -> RobotState:
    """The chart has moved; what the command changed is unconfirmed."""
    name = robot.commands[motion.command].name
    marks = marks_after(robot, state.configuration, state.marks, motion.command)
    effects.append(CommandStatus(name, "accepted", "", motion.place))
    state = state._replace(
        configuration=motion.target,
        marks=marks,
        motion=motion._replace(accepted_s=now, deadline_s=now + motion.timeout_s),
    )
    if not isinstance(robot.commands[motion.command].done, AcceptedSpec):
        effects.append(state_change(robot, state))
    return state


def _complete(
    robot: RobotSpec, state: RobotState, sensing: Sensing, reason: str, effects: list[Effect]
) -> tuple[RobotState, Finished | None]:
    """The next stage is in force, or the command is done and what it changed is confirmed."""
    motion = state.motion
    assert motion is not None  # callers have looked
    regions = tuple(
        sorted(m.which for m in state.marks if m.kind == "region" and m.command == motion.command)
    )
    target = robot.table.configurations[state.configuration]
    stages = max((len(robot.actuation[r][target[r]]) for r in regions), default=1)
    if motion.stage + 1 < stages:
        resting = state._replace(values=without_loops(state))
        values, loops = stage_array(robot, resting, motion, sensing, regions, motion.stage + 1)
        if loops or motion.stage == POSTURE:
            later = motion._replace(stage=motion.stage + 1, since_s=nan)
            return _send_if_new(state, later, values, loops, effects), None
        state = _send_if_new(state, None, values, loops, effects)
    else:
        state = _end_motion(state, effects)
    marks = frozenset(mark for mark in state.marks if mark.command != motion.command)
    state = state._replace(marks=marks)
    name = robot.commands[motion.command].name
    effects.append(CommandStatus(name, "done", reason, motion.place))
    effects.append(state_change(robot, state))
    return state, Finished(True, reason)


def _end_motion(state: RobotState, effects: list[Effect]) -> RobotState:
    """Nothing is under way; slots that a loop has really driven are zero, and no others.

    A command that was never accepted has driven nothing: what its loops were to take over may
    hold a clamp.
    """
    values = without_loops(state)
    return _send_if_new(state, None, values, (), effects)


def _send_if_new(
    state: RobotState,
    motion: Motion | None,
    values: Numbers,
    loops: tuple[Loop, ...],
    effects: list[Effect],
) -> RobotState:
    if values != state.latest:
        return _send(state, motion, values, loops, "loop", effects)
    return state._replace(motion=motion, loops=loops)
