"""Evaluate the criteria that show that a command is done."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import copysign, inf, isnan
from typing import NamedTuple

from pirate_sm.engine.control.loops import Loops
from pirate_sm.engine.control.position_loop import PositionLoop
from pirate_sm.engine.control.torque_loop import TorqueLoop
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
from pirate_sm.engine.robot.robot_spec import RobotSpec

Numbers = tuple[float, ...]

RESTORING = "resume"
"""The place of a command that a resumed mission gives before it goes on."""


class Limit(NamedTuple):
    """A limit of the signal with this number index; fields as in :class:`Unmet`."""

    signal: int
    least: float
    most: float
    magnitude: bool = False


def holds(criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: Loops) -> bool:
    """Whether the criterion is true of this moment; unknown signals never make it true.

    A joint under a torque loop bears the torque of its loop instead of the criterion's.
    """
    return next(unmet_limits(criterion, numbers, setpoints, loops), None) is None


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
                    yield _least(load.torque, needed_nm, loops)
        case ReachedSpec():
            for loop in loops:
                if isinstance(loop, PositionLoop) and not (
                    loop.arrived(numbers) or pushed_to_rest(criterion, loop, numbers, setpoints)
                ):
                    yield near(loop.angle, loop.target_rad, loop.spec.threshold_rad)
        case TurningSpec():
            driven = [(slot, speed) for slot, speed in criterion.wheels if setpoints[slot] != 0]
            ways = [(speed, copysign(1.0, setpoints[slot])) for slot, speed in driven]
            if not any(numbers[speed] * way > criterion.above for speed, way in ways):
                for speed, way in ways or [(speed, 1.0) for _, speed in criterion.wheels]:
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
                    yield near(angle, setpoints[slot], criterion.within)
        case BelowSpec():
            for signal in criterion.signals:
                if not abs(numbers[signal]) < criterion.limit:
                    yield Limit(signal, -criterion.limit, criterion.limit)


def _least(torque: int, least_nm: float, loops: Loops) -> Limit:
    """Return the torque that a joint should bear: that of its torque loop, else at least this."""
    loop = torque_loop(torque, loops)
    if loop is None:
        return Limit(torque, least_nm, inf, magnitude=True)
    return near(torque, loop.target_nm, loop.spec.within_nm)


def near(signal: int, target: float, within: float) -> Limit:
    """Return the limit that a signal is within a distance of its target."""
    return Limit(signal, target - within, target + within)


def pushed_to_rest(
    criterion: ReachedSpec, loop: PositionLoop, numbers: Numbers, setpoints: Numbers
) -> bool:
    """Return whether a joint is pushed and stands still."""
    resting = abs(numbers[loop.rate]) < criterion.still
    return resting and loop.pushes(numbers, setpoints, criterion.loaded, criterion.least_nm)


def bears(torque: int, least_nm: float, numbers: Numbers, loops: Loops) -> bool:
    """Return whether a joint bears a torque: that of its torque loop, else at least this one."""
    loop = torque_loop(torque, loops)
    if loop is not None:
        return loop.target_nm == 0 or loop.settled(numbers)
    return abs(numbers[torque]) > least_nm


def torque_loop(torque: int, loops: Loops) -> TorqueLoop | None:
    """Return the loop that keeps the torque with this number index; None without one."""
    for loop in loops:
        if isinstance(loop, TorqueLoop) and loop.spec.torque == torque:
            return loop
    return None


def still(speeds: tuple[int, ...], numbers: Numbers, below: float) -> bool:
    """Return whether at least one wheel reports and all reporting wheels turn slower."""
    heard = [abs(numbers[speed]) for speed in speeds if not isnan(numbers[speed])]
    return bool(heard) and max(heard) < below


def must_hold_s(
    criterion: CriterionSpec, numbers: Numbers, loops: tuple[PositionLoop, ...]
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
    robot: RobotSpec, criterion: CriterionSpec, numbers: Numbers, loops: tuple[PositionLoop, ...]
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
