"""Find the conditions of a command that do not hold, and what the sensors show instead."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import copysign, inf, isfinite, isnan, nan
from typing import NamedTuple

from pirate_sm.engine.control.loops import Loops, signal_of
from pirate_sm.engine.control.position_loop import PositionLoop
from pirate_sm.engine.moment import Moment
from pirate_sm.engine.robot.criteria import (
    AcceptedSpec,
    AlignedSpec,
    BelowSpec,
    CriterionSpec,
    ReachedSpec,
    StalledSpec,
    StoppedSpec,
    TurningSpec,
)
from pirate_sm.engine.robot.done import (
    bears,
    must_hold_s,
    not_done,
    pushed_to_rest,
    still,
    torque_loop,
)
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.robot.robot_state import (
    POSTURE,
    Motion,
    Numbers,
    RobotState,
    criteria_of,
    criterion_of,
    posture_of,
)
from pirate_sm.engine.sensing.known_signals import Sensing
from pirate_sm.expressions import NumberType
from pirate_sm.model.unmet import Unknown, Unmet
from pirate_sm.model.unmet_words import advice, unmet_words
from pirate_sm.units import unit_of


class Limit(NamedTuple):
    """A limit of the signal with this number index; fields as in :class:`Unmet`."""

    signal: int
    least: float
    most: float
    magnitude: bool = False


def unmet_conditions(moment: Moment, state: RobotState, sensing: Sensing) -> tuple[Unmet, ...]:
    """Return what the command under way waits for and the sensors do not show.

    It is empty while no command is under way or its array is not accepted, and in a trace.
    """
    robot, motion = moment.robot, state.motion
    if motion is None or isnan(motion.accepted_s) or moment.nominal:
        return ()
    limits = [
        _near(loop.angle, loop.target_rad, _within_rad(robot, motion, loop))
        for loop in seekers_away(robot, state, motion, sensing.numbers)
    ]
    for done, _ in reversed(criteria_of(robot, motion)):  # the one that asks for least
        if found := list(unmet_limits(done, sensing.numbers, state.values, state.loops)):
            limits += found
            break
    return tuple(
        unmet_of(robot, motion.origin, each, sensing, moment.now_s)
        for each in dict.fromkeys(limits)
    )


def unmet_limits(  # noqa: C901 - one case for each criterion
    criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: Loops
) -> Iterator[Limit]:
    """Yield the limits because of which :func:`pirate_sm.engine.robot.done.holds` is false."""
    match criterion:
        case AcceptedSpec():
            return
        case StalledSpec():
            for rate in criterion.rates:
                if not abs(numbers[rate]) < criterion.still:
                    yield Limit(rate, -criterion.still, criterion.still)
            for load in criterion.loads:
                needed_nm = load.needed_nm(setpoints)
                if not bears(load.torque, needed_nm, numbers, loops):
                    yield _torque(load.torque, needed_nm, loops)
        case ReachedSpec():
            for loop in loops:
                if isinstance(loop, PositionLoop) and not (
                    loop.arrived(numbers) or pushed_to_rest(criterion, loop, numbers, setpoints)
                ):
                    yield _near(loop.angle, loop.target_rad, loop.spec.threshold_rad)
        case TurningSpec():
            driven = [(slot, speed) for slot, speed in criterion.wheels if setpoints[slot] != 0]
            ways = [(speed, copysign(1.0, setpoints[slot])) for slot, speed in driven]
            if not any(numbers[speed] * way > criterion.above for speed, way in ways):
                for speed, way in ways:
                    limits = (criterion.above, inf) if way > 0 else (-inf, -criterion.above)
                    yield Limit(speed, *limits)
        case StoppedSpec():
            for speeds in criterion.parts:
                if still(speeds, numbers, criterion.below):
                    continue
                unheard = all(isnan(numbers[speed]) for speed in speeds)
                for speed in speeds:
                    if unheard or abs(numbers[speed]) >= criterion.below:
                        yield Limit(speed, -criterion.below, criterion.below)
        case AlignedSpec():
            for slot, angle in criterion.slots:
                if not abs(setpoints[slot] - numbers[angle]) <= criterion.within:
                    yield _near(angle, setpoints[slot], criterion.within)
        case BelowSpec():
            for signal in criterion.signals:
                if not abs(numbers[signal]) < criterion.limit:
                    yield Limit(signal, -criterion.limit, criterion.limit)


def _torque(torque: int, least_nm: float, loops: Loops) -> Limit:
    """Return the torque that a joint should bear: that of its torque loop, else at least this."""
    loop = torque_loop(torque, loops)
    if loop is None:
        return Limit(torque, least_nm, inf, magnitude=True)
    return _near(torque, loop.target_nm, loop.spec.within_nm)


def seekers_away(
    robot: RobotSpec, state: RobotState, motion: Motion, numbers: Numbers
) -> list[PositionLoop]:
    """Return the loops of the joints that have not reached their angles in the posture."""
    if motion.stage != POSTURE or posture_of(robot, motion) is None:
        return []
    return [
        loop
        for loop in state.seekers
        if not abs(loop.target_rad - numbers[loop.angle]) <= _within_rad(robot, motion, loop)
    ]


def _within_rad(robot: RobotSpec, motion: Motion, loop: PositionLoop) -> float:
    """Return how near the posture under way must be reached; its tolerance may be NaN."""
    posture = posture_of(robot, motion)
    threshold_rad = loop.spec.threshold_rad
    return threshold_rad if posture is None else max(threshold_rad, posture.within_rad)


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
        why = f" because {not_done(done)}" if posture is None else ""
        command = robot.commands[motion.command].name
        return f"{late}{why}: {unmet_words(unmet)}; {advice(unmet, command)}"
    held = [
        (moment.now_s - since_s, must_hold_s(each, sensing.numbers, state.seekers))
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


def why_held(robot: RobotSpec, held: Loops) -> str:
    """Return the reason of a failure: joints that were pushed and have not moved."""
    names = ", ".join(robot.vocabulary.numbers[signal_of(loop)] for loop in held)
    return f"not moved, though pushed: {names}; a motor is too weak, or something holds it"


def _near(signal: int, target: float, within: float) -> Limit:
    return Limit(signal, target - within, target + within)


def unmet_of(
    robot: RobotSpec, origin: Numbers, limit: Limit, sensing: Sensing, now_s: float
) -> Unmet:
    """Return a limit with what its signal shows.

    Args:
        robot: The robot.
        origin: Signals from which changes are counted; empty where they were not kept.
        limit: The limit.
        sensing: What is known now.
        now_s: The time.
    """
    signal = limit.signal
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
        limit.least,
        limit.most,
        limit.magnitude,
        value,
        age_s,
        _same(value - origin[signal]) if origin else nan,
        unknown,
        "" if board is None else f"board {board.id} ({board.module})",
    )


def _same(value: float) -> float:
    """Return the number; an unknown one as the one NaN by which equal effects are found equal."""
    return nan if isnan(value) else value
