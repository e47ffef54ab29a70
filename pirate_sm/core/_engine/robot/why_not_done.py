"""What a command lacks that is not done, what sensors show instead, and why it has failed."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, isnan, nan

from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.done_criteria import Bound, CriterionSpec, JointsArrived
from pirate_sm.core._engine.robot.loops import Loops, RunningPositionLoop, signal_of
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    POSTURE,
    Motion,
    RobotState,
    criteria_of,
    criterion_of,
    posture_bounds,
    posture_of,
)
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._expressions import NumberType
from pirate_sm.core._model.unmet import Unknown, Unmet, advice, unmet_words
from pirate_sm.core.units import unit_of


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
