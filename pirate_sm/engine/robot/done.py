"""Evaluate the criteria that show that a command is done."""

from __future__ import annotations

from math import copysign, isnan

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


def holds(criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: Loops) -> bool:
    """Whether the criterion is true of this moment; unknown signals never make it true.

    A joint under a torque loop bears the torque of its loop instead of the criterion's.
    """
    match criterion:
        case AcceptedSpec():
            return True
        case StalledSpec():
            return all(abs(numbers[rate]) < criterion.still for rate in criterion.rates) and all(
                bears(load.torque, load.needed_nm(setpoints), numbers, loops)
                for load in criterion.loads
            )
        case ReachedSpec():
            return all(
                loop.arrived(numbers) or pushed_to_rest(criterion, loop, numbers, setpoints)
                for loop in loops
                if isinstance(loop, PositionLoop)
            )
        case TurningSpec():
            return any(
                setpoints[slot] != 0
                and numbers[speed] * copysign(1.0, setpoints[slot]) > criterion.above
                for slot, speed in criterion.wheels
            )
        case StoppedSpec():
            return all(still(speeds, numbers, criterion.below) for speeds in criterion.parts)
        case AlignedSpec():
            return all(
                abs(setpoints[slot] - numbers[angle]) <= criterion.within
                for slot, angle in criterion.slots
            )
        case BelowSpec():
            return all(abs(numbers[signal]) < criterion.limit for signal in criterion.signals)


def pushed_to_rest(
    criterion: ReachedSpec, loop: PositionLoop, numbers: Numbers, setpoints: Numbers
) -> bool:
    """Return whether a joint is pushed and stands still."""
    resting = abs(numbers[loop.rate]) < criterion.still
    return resting and loop.pushes(numbers, setpoints, criterion.loaded, criterion.least_nm)


def held_loops(
    criterion: CriterionSpec, numbers: Numbers, loops: tuple[PositionLoop, ...]
) -> tuple[PositionLoop, ...]:
    """Return the loops if none of their joints has moved, so that no wall can have stopped them."""
    if not isinstance(criterion, ReachedSpec):
        return ()
    return loops if all(loop.held(numbers, criterion.moved_rad) for loop in loops) else ()


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


def in_words(
    robot: RobotSpec, criterion: CriterionSpec, numbers: Numbers, loops: tuple[PositionLoop, ...]
) -> str:
    """Return what shows that the command is done, with the joints that a wall has stopped."""
    match criterion:
        case ReachedSpec():
            names = robot.vocabulary.numbers
            stopped = [names[loop.angle] for loop in loops if not loop.arrived(numbers)]
            if stopped:
                return f"{', '.join(stopped)} stopped by the wall, standing still under torque"
            return "every joint has come to its angle"
        case AcceptedSpec():
            return "setpoints accepted"
        case StalledSpec():
            return "the joints stand still under torque"
        case TurningSpec():
            return "a driven wheel turns"
        case StoppedSpec():
            return "the wheels stand still"
        case AlignedSpec():
            return "the angle is at its setpoint"
        case BelowSpec():
            return "near zero"


def not_done(criterion: CriterionSpec) -> str:
    """Return what a command that is not done lacks, in words."""
    match criterion:
        case AcceptedSpec():
            return "its setpoints are not accepted"
        case StalledSpec():
            return "the joints do not stand still under torque"
        case ReachedSpec():
            return "not every joint is at its angle or stopped by the wall"
        case TurningSpec():
            return "no driven wheel turns"
        case StoppedSpec():
            return "the wheels are not seen to stand still"
        case AlignedSpec():
            return "the angle is not at its setpoint"
        case BelowSpec():
            return "the signals are not near zero"
