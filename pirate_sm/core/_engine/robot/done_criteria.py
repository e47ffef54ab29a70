"""Evaluate the criteria that show that a command is done, and name those that are not met."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from math import copysign, inf, isfinite, isnan, nan
from typing import Literal, NamedTuple

from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.criteria import (
    AcceptedSpec,
    AlignedSpec,
    BelowSpec,
    CriterionSpec,
    ReachedSpec,
    StalledSpec,
    StoppedSpec,
    TurningSpec,
)
from pirate_sm.core._engine.robot.loops import (
    Loops,
    RunningPositionLoop,
    RunningTorqueLoop,
    signal_of,
)
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    POSTURE,
    Motion,
    RobotState,
    criteria_of,
    criterion_of,
    posture_of,
)
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._expressions import NumberType, tree
from pirate_sm.core._model.unmet import Unknown, Unmet, advice, unmet_words
from pirate_sm.core.units import unit_of

RESTORING = "resume"
"""The place of a command that a resumed mission gives before it goes on."""


class Limit(NamedTuple):
    """A limit of the signal with this number index; fields as in :class:`Unmet`."""

    signal: int
    least: float
    most: float
    magnitude: bool = False


class Bound(NamedTuple):
    """What a criterion asks of one signal; of an unknown one nothing is true.

    Attributes:
        signal: Its number index.
        operator: How its size compares with ``limit``.
        limit: The number that its size is compared with.
        target: The value from which its size is the distance, whatever the side.
        way: 1.0 or -1.0: its size is its value in this direction instead.
        or_unknown: Whether an unknown signal counts too.
    """

    signal: int
    operator: Literal["<", "<=", ">"]
    limit: float
    target: float = 0.0
    way: float = 0.0
    or_unknown: bool = False

    def holds(self, numbers: Numbers) -> bool:
        """Return whether it is true of these numbers."""
        value = numbers[self.signal]
        size = value * self.way if self.way else abs(self.target - value)
        if self.operator == ">":
            return size > self.limit
        holds = size < self.limit if self.operator == "<" else size <= self.limit
        return holds or (self.or_unknown and isnan(value))

    @property
    def condition(self) -> tree.Node:
        """Return it as a condition."""
        signal: tree.Node = tree.Signal("", "number", self.signal)
        if self.way:
            size = signal if self.way > 0 else tree.Negate(signal)
        else:
            off = tree.Arithmetic("-", tree.Number(self.target), signal) if self.target else signal
            size = tree.Call("abs", (off,))
        bound = tree.Compare(self.operator, size, tree.Number(self.limit))
        return tree.Or((tree.Not(tree.Known(signal)), bound)) if self.or_unknown else bound

    @property
    def shown(self) -> Limit:
        """Return it as messages name it."""
        if self.way:
            ends = (self.limit, inf) if self.way > 0 else (-inf, -self.limit)
            return Limit(self.signal, *ends)
        if self.operator == ">":
            return Limit(self.signal, self.limit, inf, magnitude=True)
        return Limit(self.signal, self.target - self.limit, self.target + self.limit)


class Need(NamedTuple):
    """One of the things that a criterion needs, all of which must be true.

    Attributes:
        ways: The ways in which it is true: in each all of its bounds hold.
        lacking: The bounds that it lacks where it is not true.
    """

    ways: tuple[tuple[Bound, ...], ...]
    lacking: tuple[Bound, ...]

    def holds(self, numbers: Numbers) -> bool:
        """Return whether it is true of these numbers."""
        for way in self.ways:  # loops, since this is asked with each frame
            for bound in way:
                if not bound.holds(numbers):
                    break
            else:
                return True
        return False

    @property
    def condition(self) -> tree.Node:
        """Return it as a condition."""
        return tree.Or(tuple(tree.And(tuple(each.condition for each in way)) for way in self.ways))


def _only(bound: Bound) -> Need:
    return Need(((bound,),), (bound,))


def near(signal: int, target: float, within: float) -> Bound:
    """Return the bound that a signal is at most this far from a value."""
    return Bound(signal, "<=", within, target)


def arrived(loop: RunningPositionLoop) -> Bound:
    """Return the bound that the loop's joint is at its angle."""
    return near(loop.angle, loop.target_rad, loop.spec.threshold_rad)


@lru_cache(maxsize=1024, typed=True)  # asked for with each frame; tuples of two kinds can be equal
def needs(criterion: CriterionSpec, setpoints: Numbers, loops: Loops) -> tuple[Need, ...]:
    """Return what a criterion needs under these setpoints; what is unknown never makes it true.

    A joint under a torque loop bears the torque of its loop instead of the criterion's.
    """
    return tuple(_needs(criterion, setpoints, loops))


def _needs(  # noqa: C901 - one case for each criterion
    criterion: CriterionSpec, setpoints: Numbers, loops: Loops
) -> Iterator[Need]:
    match criterion:
        case AcceptedSpec():
            return
        case StalledSpec():
            for rate in criterion.rates:
                yield _only(Bound(rate, "<", criterion.still))
            for load in criterion.loads:
                loop = _torque_loop(load.torque, loops)
                if loop is None:
                    yield _only(Bound(load.torque, ">", load.needed_nm(setpoints)))
                elif loop.target_nm:
                    yield _only(near(load.torque, loop.target_nm, loop.spec.within_nm))
        case ReachedSpec():
            for seeker in loops:
                if isinstance(seeker, RunningPositionLoop):
                    yield _reached(criterion, setpoints[seeker.slot], seeker)
        case TurningSpec():
            ways = [(speed, setpoints[slot]) for slot, speed in criterion.wheels if setpoints[slot]]
            bounds = tuple(
                Bound(speed, ">", criterion.above, way=copysign(1.0, way))
                for speed, way in ways or [(speed, 1.0) for _, speed in criterion.wheels]
            )
            yield Need(tuple((each,) for each in bounds) if ways else (), bounds)
        case StoppedSpec():
            for speeds in criterion.parts:
                slow = [Bound(each, "<", criterion.below, or_unknown=True) for each in speeds]
                heard = tuple((Bound(each, ">", -1.0),) for each in speeds)  # any number will do
                yield Need(heard, tuple(slow))
                yield from map(_only, slow)
        case AlignedSpec():
            for slot, angle in criterion.slots:
                yield _only(near(angle, setpoints[slot], criterion.within))
        case BelowSpec():
            for signal in criterion.signals:
                yield _only(Bound(signal, "<", criterion.limit))


def _reached(criterion: ReachedSpec, duty: float, loop: RunningPositionLoop) -> Need:
    """Return that a joint is at its angle, or pushed and standing still."""
    there = arrived(loop)
    if duty == 0:
        return _only(there)
    pushed_nm = loop.pushed_nm(duty, criterion.loaded, criterion.least_nm)
    pushed = Bound(loop.torque, ">", pushed_nm, way=copysign(1.0, duty))
    return Need(((there,), (Bound(loop.rate, "<", criterion.still), pushed)), (there,))


def holds(criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: Loops) -> bool:
    """Whether the criterion is true of this moment."""
    return all(need.holds(numbers) for need in needs(criterion, setpoints, loops))


def criterion_tree(criterion: CriterionSpec, setpoints: Numbers, loops: Loops) -> tree.Node:
    """Return the criterion as a condition on the signals."""
    parts = tuple(need.condition for need in needs(criterion, setpoints, loops))
    return tree.And(parts) if parts else tree.TruthValue(True)


def _unmet_limits(
    criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: Loops
) -> Iterator[Limit]:
    """Yield the limits because of which :func:`holds` is false."""
    for need in needs(criterion, setpoints, loops):
        if not need.holds(numbers):
            yield from (bound.shown for bound in need.lacking)


def _torque_loop(torque: int, loops: Loops) -> RunningTorqueLoop | None:
    """Return the loop that keeps the torque with this number index; None without one."""
    for loop in loops:
        if isinstance(loop, RunningTorqueLoop) and loop.spec.torque == torque:
            return loop
    return None


def must_hold_s(
    criterion: CriterionSpec, numbers: Numbers, loops: tuple[RunningPositionLoop, ...]
) -> float:
    """Return for how long the criterion must have been true."""
    if isinstance(criterion, ReachedSpec):
        return 0.0 if all(loop.arrived(numbers) for loop in loops) else criterion.for_s
    return getattr(criterion, "for_s", 0.0)


_IN_WORDS: Mapping[type[CriterionSpec], tuple[str, str]] = {
    AcceptedSpec: ("setpoints accepted", "its setpoints are not accepted"),
    StalledSpec: (
        "the joints stand still under torque",
        "the joints do not stand still under torque",
    ),
    ReachedSpec: (
        "every joint has come to its angle",
        "not every joint is at its angle or stopped by the wall",
    ),
    TurningSpec: ("a driven wheel turns", "no driven wheel turns"),
    StoppedSpec: ("the wheels stand still", "the wheels are not seen to stand still"),
    AlignedSpec: ("the angle is at its setpoint", "the angle is not at its setpoint"),
    BelowSpec: ("near zero", "the signals are not near zero"),
}
"""What shows that a command is done, and what one that is not done lacks."""


def in_words(
    robot: RobotSpec,
    criterion: CriterionSpec,
    numbers: Numbers,
    loops: tuple[RunningPositionLoop, ...],
) -> str:
    """Return what shows that the command is done, with the joints that a wall has stopped."""
    names = robot.vocabulary.numbers
    stopped = [names[loop.angle] for loop in loops if not loop.arrived(numbers)]
    if stopped and isinstance(criterion, ReachedSpec):
        return f"{', '.join(stopped)} stopped by the wall, standing still under torque"
    return _IN_WORDS[type(criterion)][0]


def not_done(criterion: CriterionSpec) -> str:
    """Return what a command that is not done lacks, in words."""
    return _IN_WORDS[type(criterion)][1]


# --- what a command lacks that is not done, and what sensors show instead ---------------------


def unmet_conditions(moment: Moment, state: RobotState, sensing: Sensing) -> tuple[Unmet, ...]:
    """Return what the command under way waits for and the sensors do not show.

    It is empty while no command is under way or its array is not accepted, and in a trace.
    """
    robot, motion = moment.robot, state.motion
    if motion is None or isnan(motion.accepted_s) or moment.nominal:
        return ()
    limits = [
        each.shown
        for each in posture_bounds(robot, state, motion)
        if not each.holds(sensing.numbers)
    ]
    for done, _ in reversed(criteria_of(robot, motion)):  # the one that asks for least
        if found := list(_unmet_limits(done, sensing.numbers, state.values, state.loops)):
            limits += found
            break
    return tuple(
        unmet_of(robot, motion.origin, each, sensing, moment.now_s)
        for each in dict.fromkeys(limits)
    )


def posture_bounds(robot: RobotSpec, state: RobotState, motion: Motion) -> tuple[Bound, ...]:
    """Return where the joints must be in the posture under way; none outside of one."""
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return ()
    return tuple(  # the tolerance of a posture may be NaN
        near(loop.angle, loop.target_rad, max(loop.spec.threshold_rad, posture.within_rad))
        for loop in state.seekers
    )


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


def why_unmoved(robot: RobotSpec, unmoved: Loops) -> str:
    """Return the reason of a failure: joints that were pushed and have not moved."""
    names = ", ".join(robot.vocabulary.numbers[signal_of(loop)] for loop in unmoved)
    return f"not moved, though pushed: {names}; a motor is too weak, or something holds it"


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
