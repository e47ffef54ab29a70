"""Evaluate the criteria that show that a command is done."""

from __future__ import annotations

from math import copysign, isnan

from pirate_sm.engine.control.position_loop import PositionLoop
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


def holds(
    criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: tuple[PositionLoop, ...]
) -> bool:
    """Return whether the criterion is met at this moment; False for unknown signals."""
    match criterion:
        case AcceptedSpec():
            return True
        case StalledSpec():
            return all(abs(numbers[rate]) < criterion.still for rate in criterion.rates) and all(
                abs(numbers[torque]) > criterion.torque for torque in criterion.torques
            )
        case ReachedSpec():
            return all(
                loop.arrived(numbers)
                or (
                    abs(numbers[loop.rate]) < criterion.still
                    and loop.pushes(numbers, setpoints, criterion.loaded)
                )
                for loop in loops
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
