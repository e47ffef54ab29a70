"""Compute what a command would change now, why it is refused, and why it is not done."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from math import isfinite, isnan, nan

from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import Bound, CriterionSpec, JointsArrived
from pirate_sm.core._engine.robot.levelling import levelling_of
from pirate_sm.core._engine.robot.loops import Loops, RunningPositionLoop, signal_of
from pirate_sm.core._engine.robot.robot_spec import CommandSpec, Configuration, RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DENIED,
    MOST_REMEMBERED,
    POSTURE,
    Mark,
    Marks,
    Motion,
    RobotState,
    confirmed_at,
    criteria_of,
    criterion_of,
    posture_bounds,
    posture_of,
)
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._expressions import NumberType
from pirate_sm.core._model.unmet import Unknown, Unmet, advice, unmet_words
from pirate_sm.core.units import unit_of

# --- what it would change, and why it is refused ----------------------------------------------


def refusal(robot: RobotSpec, state: RobotState, command: int) -> str:
    """Return why the command would be refused now; empty if it is possible.

    A reason begins with *unneeded* or *impossible*. A command is possible when it moves the chart,
    its posture does not rule it out, a confirmed clamp remains if it releases a part, and wheels
    are driven only with a confirmed clamp. A command that moves nothing is possible as a retry
    while the state that it asks for is unconfirmed.
    """
    return _refusal(robot, state.configuration, state.marks, command)


@lru_cache(maxsize=MOST_REMEMBERED)
def _refusal(robot: RobotSpec, here: int, marks: Marks, command: int) -> str:
    target = robot.table.follow(here, command)
    if target == here and not _retried(robot, here, marks, command):
        if robot.unneeded[here][command]:
            return "unneeded: it is so already"
        return f"impossible: {robot.table.why_not(here, command)}"
    posture = robot.commands[command].posture(target)
    if posture is not None and posture.refuse:
        return f"impossible: {posture.refuse}"
    confirmed, held = confirmed_at(robot, here, marks), robot.held[target]
    made = _made_by(robot, here, marks, command)
    if len(confirmed & held) != 1 and levelling_of(robot, tuple(made), target):
        return "impossible: exactly one part must hold, confirmed, while the other one turns"
    if made & robot.driven[target].keys() and not confirmed & held:
        return f"impossible: no clamp is confirmed to drive with{_lacking(robot, held, marks)}"
    if robot.held[here] <= held or confirmed & held or robot.commands[command].lets_go:
        return ""
    if not confirmed:
        return f"impossible: no clamp that would remain is confirmed{_lacking(robot, held, marks)}"
    parts = ", ".join(robot.parts[part] for part in sorted(confirmed))
    lacking = _lacking(robot, held, marks)
    return f"impossible: it would let go of the last confirmed clamp ({parts}){lacking}"


def lets_all_go(robot: RobotSpec, state: RobotState, command: str) -> bool:
    """Return whether nothing holds the robot after the command, and something does now."""
    lets_go = robot.commands[robot.table.command_index[command]].lets_go
    return lets_go and bool(robot.held[state.configuration])


def _lacking(robot: RobotSpec, held: frozenset[int], marks: Marks) -> str:
    """Return which proof is missing of each held part that is not confirmed; empty if none is."""
    found = [
        f"{robot.parts[mark.which]}: "
        + ("its clamp is denied" if mark.command == DENIED else "no sensor has shown that it holds")
        for mark in sorted(marks)
        if mark.kind == "part" and mark.which in held
    ]
    return "".join(f"; {each}" for each in dict.fromkeys(found))


@lru_cache(maxsize=MOST_REMEMBERED)
def touched(robot: RobotSpec, here: int, marks: Marks, command: int) -> tuple[tuple[int, ...], int]:
    """Return the regions that the command actuates, and its first stage.

    A command that only confirms a clamp again writes the actuation in force, which is the last
    stage of that state.
    """
    made = _made_by(robot, here, marks, command)
    clamps = [m for m in _retried(robot, here, marks, command) if m.kind == "part"]
    regions = made.union(*(robot.part_regions[mark.which] for mark in clamps))
    if made:
        return tuple(sorted(regions)), 0
    target = robot.table.configurations[robot.table.follow(here, command)]
    stages = (len(robot.actuation[region][target[region]]) for region in regions)
    return tuple(sorted(regions)), max(stages, default=1) - 1


@lru_cache(maxsize=MOST_REMEMBERED)
def marks_after(robot: RobotSpec, here: int, marks: Marks, command: int) -> Marks:
    """Return the unconfirmed marks after the acceptance of the command's first array."""
    made = _made_by(robot, here, marks, command)
    held, was_held = robot.held[robot.table.follow(here, command)], robot.held[here]
    again = {m.which for m in _retried(robot, here, marks, command) if m.kind == "part"}
    kept = {
        mark
        for mark in marks
        if (mark.kind == "region" and mark.which not in made)
        or (mark.kind == "part" and mark.which in held and mark.which not in again)
    }
    kept |= {Mark("region", region, command) for region in made}
    kept |= {Mark("part", part, command) for part in (held - was_held) | again & held}
    return frozenset(kept)


def doubt_grip(robot: RobotSpec, state: RobotState) -> RobotState:
    """Mark the held parts as unconfirmed if the command under way has moved their joints.

    It has moved them if its first array, which starts a posture, was accepted.
    """
    motion = state.motion
    if motion is None or isnan(motion.accepted_s):
        return state
    if posture_of(robot, motion) is None:
        return state
    marks = {Mark("part", part, DENIED) for part in robot.held[state.configuration]}
    return state._replace(marks=state.marks | marks)


def _made_by(robot: RobotSpec, here: int, marks: Marks, command: int) -> frozenset[int]:
    """Return the regions whose states the command sets: those that it moves or retries."""
    before = robot.table.configurations[here]
    after = robot.table.configurations[robot.table.follow(here, command)]
    moved = {index for index, name in enumerate(after) if name != before[index]}
    again = {m.which for m in _retried(robot, here, marks, command) if m.kind == "region"}
    return frozenset(moved | again)


def _retried(robot: RobotSpec, here: int, marks: Marks, command: int) -> Marks:
    """Return the marks that the command, given now, would confirm.

    These are the marks that the same command left. If the state that it asks for is commanded
    already, they include the unconfirmed states or clamps on which that depends.
    """
    own = {mark for mark in marks if mark.command == command}
    if not robot.unneeded[here][command] or robot.table.follow(here, command) != here:
        return frozenset(own)
    return frozenset(own | _rests_on(robot, here, marks, command))


def _rests_on(robot: RobotSpec, here: int, marks: Marks, command: int) -> set[Mark]:
    """Return the marks that leave it open whether the command is unneeded."""
    spec = robot.commands[command]
    if spec.asks_parts:
        return {mark for mark in marks if mark.kind == "part" and mark.which in spec.asks_parts}
    doubted = {mark.which for mark in marks if mark.kind == "region"}
    names = robot.table.configurations[here]
    if _is_so(names, spec, doubted):
        return set()
    alone = {
        region
        for region in doubted
        if not _is_so(names, spec, {region}) or _is_so(names, spec, doubted - {region})
    }
    regions = alone or doubted
    return {mark for mark in marks if mark.kind == "region" and mark.which in regions}


def _is_so(names: Configuration, spec: CommandSpec, unknown: set[int]) -> bool:
    """Return whether a command's ``asks_for`` holds for every state of the unknown regions."""
    words = tuple(None if index in unknown else name for index, name in enumerate(names))
    return spec.asks_for is not None and spec.asks_for.evaluate((), words) is True


# --- what it lacks that is not done -----------------------------------------------------------


def shown_done(
    robot: RobotSpec,
    criterion: CriterionSpec,
    numbers: Numbers,
    loops: tuple[RunningPositionLoop, ...],
) -> str:
    """Return what shows that the command is done, with the joints that a wall has stopped."""
    names = robot.vocabulary.numbers
    stopped = [names[loop.angle] for loop in loops if not loop.arrived(numbers)]
    if stopped and criterion.asked(JointsArrived):
        return f"{', '.join(stopped)} stopped by the wall, standing still under torque"
    return criterion.shown


def unmet_conditions(moment: Moment, state: RobotState, sensing: Sensing) -> tuple[Unmet, ...]:
    """Return what the command under way waits for and the sensors do not show.

    It is empty while no command is under way or its array is not accepted, and in a trace.
    """
    robot, motion = moment.robot, state.motion
    if motion is None or isnan(motion.accepted_s) or moment.nominal:
        return ()
    numbers = sensing.numbers
    lacking = [each for each in posture_bounds(robot, state, motion) if not each.holds(numbers)]
    for done, _ in reversed(criteria_of(robot, motion)):  # the one that asks for least
        if found := done.lacks(numbers, state.values, state.loops):
            lacking += found
            break
    unmet = (unmet_of(robot, motion.origin, each, sensing, moment.now_s) for each in lacking)
    return tuple(dict.fromkeys(unmet))


def why_late(
    moment: Moment, state: RobotState, motion: Motion, unmet: tuple[Unmet, ...], sensing: Sensing
) -> str:
    """Return the reason of a timeout: what was not done in time, what is shown, what to do next.

    Args:
        moment: When it is, and the robot.
        state: The robot's state.
        motion: The command under way.
        unmet: The conditions that do not hold.
        sensing: What is known now.
    """
    robot = moment.robot
    done = criterion_of(robot, motion)
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    what = "not done" if posture is None else f"not in the posture '{posture.name}'"
    late = f"{what} within {motion.timeout_s:g} s"
    if unmet:
        why = f" because {done.lacking}" if posture is None else ""
        command = robot.commands[motion.command].name
        return f"{late}{why}: {unmet_words(unmet)}; {advice(unmet, command)}"
    held = [
        (moment.now_s - since_s, each.must_hold_s(sensing.numbers, state.seekers))
        for each, since_s in criteria_of(robot, motion)
        if not isnan(since_s)
    ]
    if not held:
        return late
    held_s, needed_s = min(held, key=lambda it: it[1] - it[0])
    return f"{late}: it has held for {held_s:.3g} s of {needed_s:g} s"


def why_not_clamped(state: RobotState, motion: Motion, denied: Mapping[int, str]) -> str:
    """Return why a part that the command under way clamps does not hold; empty if it may."""
    own = [mark for mark in sorted(state.marks) if mark.command == motion.command]
    return next((denied[m.which] for m in own if m.kind == "part" and m.which in denied), "")


def why_unmoved(robot: RobotSpec, unmoved: Loops) -> str:
    """Return the reason of a failure: joints that were pushed and have not moved."""
    names = ", ".join(robot.vocabulary.numbers[signal_of(loop)] for loop in unmoved)
    return f"not moved, though pushed: {names}; a motor is too weak, or something holds it"


def unmet_of(
    robot: RobotSpec, origin: Numbers, bound: Bound, sensing: Sensing, now_s: float
) -> Unmet:
    """Return a bound in words of limits, with what its signal shows.

    Args:
        robot: The robot.
        origin: Signals from which changes are counted; empty where they were not kept.
        bound: The bound.
        sensing: What is known now.
        now_s: The time.
    """
    signal = bound.signal
    value = _same(sensing.shown[signal])
    board = next((it for it in robot.boards.values() if signal in it.number_set), None)
    age_s = nan if board is None else now_s - sensing.heard_s[board.position]
    unknown: Unknown = ""
    if isnan(value):
        if board is not None and (board.position in sensing.stale or not isfinite(age_s)):
            unknown = "silent"
        else:
            unknown = "implausible" if signal in sensing.doubted else "missing"
    name = robot.vocabulary.numbers[signal]
    kind = robot.vocabulary.types[name]
    return Unmet(
        name,
        unit_of(kind.dimension) if isinstance(kind, NumberType) else "",
        *bound.limits,
        value,
        age_s,
        _same(value - origin[signal]) if origin else nan,
        unknown,
        "" if board is None else f"board {board.id} ({board.module})",
    )


def _same(value: float) -> float:
    """Return the number; an unknown one as the one NaN by which equal effects are found equal."""
    return nan if isnan(value) else value
