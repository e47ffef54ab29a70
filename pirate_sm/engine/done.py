"""Whether what a command asked for has happened; told by signals, not by having been sent."""

from __future__ import annotations

from math import copysign, isnan
from typing import NamedTuple

from pirate_sm.engine.criteria import (
    AcceptedSpec,
    AlignedSpec,
    BelowSpec,
    CriterionSpec,
    ReachedSpec,
    StalledSpec,
    StoppedSpec,
    TurningSpec,
)
from pirate_sm.engine.robot import LoopSpec, RobotSpec

Numbers = tuple[float, ...]


class Loop(NamedTuple):
    """A running position loop.

    Attributes:
        slot: Whose duty it sets.
        angle: Number index of the controlled angle; ``rate`` that of its rate.
        torque: Number index of the torque that its joint bears.
        target_rad: Where it shall come to.
    """

    slot: int
    angle: int
    rate: int
    torque: int
    spec: LoopSpec
    target_rad: float

    def arrived(self, numbers: Numbers) -> bool:
        """Whether the angle is inside the threshold; an unknown angle has not arrived."""
        return abs(self.target_rad - numbers[self.angle]) <= self.spec.threshold_rad

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle of a proportional controller, 0 once arrived or when blind.

        Args:
            numbers: Signals.
            loss: Share of reports that is lost. The gain is smaller by it: where the array that
                stops the joint may come late, the joint comes to its angle more slowly.
        """
        error = self.target_rad - numbers[self.angle]
        if not abs(error) > self.spec.threshold_rad:
            return 0.0
        size = min(
            max(abs(error) * self.spec.gain * (1 - loss), self.spec.least_duty), self.spec.limit
        )
        return size if error > 0 else -size

    def pushes(self, numbers: Numbers, setpoints: Numbers, share: float) -> bool:
        """Whether the joint bears ``share`` of the torque that its duty gives at stall."""
        duty = setpoints[self.slot]
        borne = numbers[self.torque] * (1.0 if duty > 0 else -1.0)
        return duty != 0 and borne > share * abs(duty) * self.spec.stall_torque_nm


def holds(
    criterion: CriterionSpec, numbers: Numbers, setpoints: Numbers, loops: tuple[Loop, ...]
) -> bool:
    """Whether the criterion is true of this moment; unknown signals never make it true."""
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
    """Whether at least one of the wheels can be heard, and all of these turn slower."""
    heard = [abs(numbers[speed]) for speed in speeds if not isnan(numbers[speed])]
    return bool(heard) and max(heard) < below


def must_hold_s(criterion: CriterionSpec, numbers: Numbers, loops: tuple[Loop, ...]) -> float:
    """For how long the criterion must have been true."""
    if isinstance(criterion, ReachedSpec):
        return 0.0 if all(loop.arrived(numbers) for loop in loops) else criterion.for_s
    return getattr(criterion, "for_s", 0.0)


def told(
    robot: RobotSpec, criterion: CriterionSpec, numbers: Numbers, loops: tuple[Loop, ...]
) -> str:
    """In words, what showed that the command is done; which joints a wall has stopped."""
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
