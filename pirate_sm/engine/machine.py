"""The robot's state machines in motion: commands, arrays in flight, confirmation, position loops.

Pure functions over :class:`RobotState`. The chart moves when a command's first array has been
accepted; until the command is seen to be done its new states are *unconfirmed*, and an
unconfirmed clamp is no clamp.
"""

from __future__ import annotations

from math import inf, isnan, nan

from pirate_sm.engine.done import Loop, holds, must_hold_s, told
from pirate_sm.engine.moments import has_come
from pirate_sm.engine.robot import AcceptedSpec, RobotSpec, StageSpec
from pirate_sm.engine.robot_state import (
    Finished,
    Flight,
    Mark,
    Motion,
    Numbers,
    Purpose,
    RobotState,
    known_values,
    safe_values,
    state_change,
    states_of,
)
from pirate_sm.engine.sensing import Sensing
from pirate_sm.model.effects import CommandStatus, Effect, Setpoints
from pirate_sm.model.events import SubmitResult


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
    state = state._replace(motion=motion)
    values, loops = _actuate(robot, state, sensing, _touched(robot, state, motion), 0)
    effects.append(CommandStatus(spec.name, "sent", "", place))
    return _send(state._replace(loops=loops), values, "gate", effects)


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
    since_s = motion.since_s
    if holds(spec.done, sensing.numbers, state.values, state.loops):
        since_s = now if isnan(since_s) else since_s
        held_s = must_hold_s(spec.done, sensing.numbers, state.loops)
        if free and has_come(now, since_s + held_s):
            reason = told(robot, spec.done, sensing.numbers, state.loops)
            return _complete(robot, state, sensing, reason, effects)
    elif not isnan(since_s):
        since_s = nan
    if free and has_come(now, motion.deadline_s):
        reason = f"not done within {motion.timeout_s:g} s"
        return fail(robot, state, reason, effects), Finished(False, reason)
    if since_s is not motion.since_s:
        state = state._replace(motion=motion._replace(since_s=since_s))
    if free and state.loops:
        state = _step_loops(robot, state, sensing, effects)
    return state, None


def fail(robot: RobotSpec, state: RobotState, reason: str, effects: list[Effect]) -> RobotState:
    """The command under way is over without being done; its states stay unconfirmed.

    Its position loops stop where they are.
    """
    motion = state.motion
    if motion is None:
        return state
    name = robot.commands[motion.command].name
    effects.append(CommandStatus(name, "failed", reason, motion.place))
    return _end_motion(state, effects)


def skip(robot: RobotSpec, state: RobotState, effects: list[Effect]) -> RobotState:
    """The operator has passed over the command under way; its states stay unconfirmed."""
    motion = state.motion
    if motion is None:
        return state
    name = robot.commands[motion.command].name
    effects.append(CommandStatus(name, "skipped", "by the operator", motion.place))
    return _end_motion(state, effects)


def stop(
    robot: RobotSpec, state: RobotState, sensing: Sensing, effects: list[Effect]
) -> RobotState:
    """The safe array has been sent, whatever else was in flight."""
    values = safe_values(robot, state, sensing.numbers)
    return _send(state._replace(loops=()), values, "stop", effects)


def reassert(
    state: RobotState, values: Numbers, loops: tuple[Loop, ...], effects: list[Effect]
) -> RobotState:
    """An actuation that was in force before a pause has been sent again."""
    kept = tuple(
        now if isnan(value) else value for value, now in zip(values, state.values, strict=True)
    )
    return _send(state._replace(loops=loops), kept, "loop", effects)


def doubt(robot: RobotSpec, state: RobotState) -> RobotState:
    """Regions whose wheels were stopped from outside their states are unconfirmed."""
    driven = robot.driven[state.configuration]
    if not driven:
        return state
    return state._replace(marks=state.marks | {Mark("region", each, -1) for each in driven})


# --- inside ---------------------------------------------------------------------------------


def _send(
    state: RobotState, values: Numbers, purpose: Purpose, effects: list[Effect]
) -> RobotState:
    effects.append(Setpoints(state.next_id, values))
    seeking = frozenset(loop.slot for loop in state.loops)
    flight = Flight(state.next_id, values, purpose, seeking=seeking)
    return state._replace(flight=flight, next_id=state.next_id + 1, sent=True)


def _touched(robot: RobotSpec, state: RobotState, motion: Motion) -> tuple[int, ...]:
    """Regions that the command moves, or that it left unconfirmed and now tries again."""
    before = states_of(robot, state)
    after = robot.table.configurations[motion.target]
    moved = {index for index, name in enumerate(after) if name != before[index]}
    retried = [mark for mark in state.marks if mark.command == motion.command]
    for mark in retried:
        moved |= {mark.which} if mark.kind == "region" else robot.part_regions[mark.which]
    return tuple(sorted(moved))


def _actuate(
    robot: RobotSpec, state: RobotState, sensing: Sensing, regions: tuple[int, ...], stage: int
) -> tuple[Numbers, tuple[Loop, ...]]:
    """The array that puts a stage of the regions' states in force, and its position loops."""
    motion = state.motion
    target = robot.table.configurations[motion.target if motion else state.configuration]
    values = list(known_values(state.latest, sensing.numbers, robot))
    loops: list[Loop] = []
    for region in regions:
        stages = robot.actuation[region][target[region]]
        _write(robot, sensing, stages[min(stage, len(stages) - 1)], values, loops)
    return tuple(values), tuple(loops)


def _write(
    robot: RobotSpec, sensing: Sensing, stage: StageSpec, values: list[float], loops: list[Loop]
) -> None:
    for write in stage:
        slot = robot.slots[write.slot]
        if write.how == "set":
            values[write.slot] = write.value
        elif write.how == "seek" and slot.loop is not None:
            loop = Loop(write.slot, slot.angle, slot.rate, slot.torque, slot.loop, write.value)
            loops.append(loop)
            values[write.slot] = _quantised(loop.duty(sensing.numbers), slot.resolution)


def _accept(
    robot: RobotSpec, state: RobotState, motion: Motion, now: float, effects: list[Effect]
) -> RobotState:
    """The chart has moved; what the command changed is unconfirmed."""
    name = robot.commands[motion.command].name
    touched = _touched(robot, state, motion)
    held, was_held = robot.held[motion.target], robot.held[state.configuration]
    again = {m.which for m in state.marks if m.kind == "part" and m.command == motion.command}
    marks = {
        mark
        for mark in state.marks
        if (mark.kind == "region" and mark.which not in touched)
        or (mark.kind == "part" and mark.which in held and mark.which not in again)
    }
    marks |= {Mark("region", region, motion.command) for region in touched}
    marks |= {Mark("part", part, motion.command) for part in (held - was_held) | again & held}
    effects.append(CommandStatus(name, "accepted", "", motion.place))
    state = state._replace(
        configuration=motion.target,
        marks=frozenset(marks),
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
        values, loops = _actuate(robot, state, sensing, regions, motion.stage + 1)
        state = _send_if_new(state._replace(loops=loops), values, effects)
        if loops:
            later = motion._replace(stage=motion.stage + 1, since_s=nan)
            return state._replace(motion=later), None
        state = state._replace(motion=None)
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
    values = list(state.values)
    for slot in state.seeking:
        values[slot] = 0.0
    return _send_if_new(state._replace(motion=None, loops=()), tuple(values), effects)


def _send_if_new(state: RobotState, values: Numbers, effects: list[Effect]) -> RobotState:
    return state if values == state.latest else _send(state, values, "loop", effects)


def _step_loops(
    robot: RobotSpec, state: RobotState, sensing: Sensing, effects: list[Effect]
) -> RobotState:
    """Each position loop has had its say; no array is in flight."""
    values = list(state.values)
    for loop in state.loops:
        resolution = robot.slots[loop.slot].resolution
        values[loop.slot] = _quantised(loop.duty(sensing.numbers), resolution)
    return _send_if_new(state, tuple(values), effects)


def _quantised(value: float, resolution: float) -> float:
    return round(value / resolution) * resolution
