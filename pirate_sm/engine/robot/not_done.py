"""Say what a command lacks that is not done: which sensors do not show it, and what they show."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees, isnan

from pirate_sm import units
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
from pirate_sm.engine.robot.done import holds, must_hold_s, still
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.known_signals import Sensing
from pirate_sm.expressions.vocabulary import NumberType

Numbers = tuple[float, ...]

_IN_WORDS = {
    units.ANGLE: (degrees(1.0), ".1f", " deg"),
    units.ANGULAR_SPEED: (1.0, ".2f", " rad/s"),
    units.TORQUE: (1000.0, ".0f", " mNm"),
    units.CURRENT: (1000.0, ".0f", " mA"),
    units.LENGTH: (1000.0, ".0f", " mm"),
}
"""Per dimension the factor from SI, the form and the unit in which people read it."""


def lacking(
    robot: RobotSpec, criterion: CriterionSpec, sensing: Sensing, setpoints: Numbers, loops: Loops
) -> str:
    """Return what a criterion lacks now, signal by signal.

    A criterion that holds now has not held for long enough. The text is empty only for a command
    that is done when its setpoints are accepted.

    Args:
        robot: The robot.
        criterion: What shows that the command is done.
        sensing: What is known now.
        setpoints: The accepted array.
        loops: The loops that run.
    """
    if isinstance(criterion, AcceptedSpec):
        return ""
    if holds(criterion, sensing.numbers, setpoints, loops):
        seekers = tuple(loop for loop in loops if isinstance(loop, PositionLoop))
        return (
            f"it is so now, but not yet for {must_hold_s(criterion, sensing.numbers, seekers):g} s"
        )
    return "; ".join(_Shown(robot, sensing).misses(criterion, setpoints, loops))


def not_at_their_angles(robot: RobotSpec, sensing: Sensing, away: Iterable[PositionLoop]) -> str:
    """Return the angle that the joint of each of these loops shows, and the one that it seeks."""
    shown = _Shown(robot, sensing)
    return "; ".join(shown.is_not(loop.angle, "at", loop.target_rad) for loop in away)


class _Shown:
    """Words for the signals that a criterion asks for.

    Attributes:
        numbers: Signals now, SI; NaN is unknown.
    """

    def __init__(self, robot: RobotSpec, sensing: Sensing) -> None:
        self.numbers = sensing.numbers
        self._robot, self._sensing = robot, sensing

    def misses(self, criterion: CriterionSpec, setpoints: Numbers, loops: Loops) -> list[str]:
        """Return each signal that the criterion lacks, with its value and the limit."""
        numbers = self.numbers
        match criterion:
            case StalledSpec():
                return self._not_stalled(criterion, loops)
            case ReachedSpec():
                seekers = (loop for loop in loops if isinstance(loop, PositionLoop))
                return [
                    self.is_not(loop.angle, "at", loop.target_rad)
                    for loop in seekers
                    if not loop.arrived(numbers)
                ]
            case TurningSpec():
                driven = [speed for slot, speed in criterion.wheels if setpoints[slot] != 0]
                return [self.is_not(speed, "above", criterion.above) for speed in driven] or [
                    "no wheel is driven"
                ]
            case StoppedSpec():
                return [
                    words
                    for part in criterion.parts
                    if not still(part, numbers, criterion.below)
                    for words in self._moving(part, criterion.below)
                ]
            case AlignedSpec():
                return [
                    self.is_not(angle, "at", setpoints[slot])
                    for slot, angle in criterion.slots
                    if not abs(setpoints[slot] - numbers[angle]) <= criterion.within
                ]
            case BelowSpec():
                return self._not_below(criterion.signals, criterion.limit)
            case AcceptedSpec():
                return []

    def _not_stalled(self, criterion: StalledSpec, loops: Loops) -> list[str]:
        targets = {loop.spec.torque: loop for loop in loops if isinstance(loop, TorqueLoop)}
        weak = []
        for torque in criterion.torques:
            loop = targets.get(torque)
            if loop is None and not abs(self.numbers[torque]) > criterion.torque:
                weak.append(self.is_not(torque, "above", criterion.torque))
            elif loop is not None and loop.target_nm and not loop.settled(self.numbers):
                weak.append(self.is_not(torque, "at", loop.target_nm))
        return self._not_below(criterion.rates, criterion.still) + weak

    def _not_below(self, signals: tuple[int, ...], limit: float) -> list[str]:
        return [
            self.is_not(signal, "below", limit)
            for signal in signals
            if not abs(self.numbers[signal]) < limit
        ]

    def _moving(self, part: tuple[int, ...], below: float) -> list[str]:
        """Return the wheels of a part that turn; all of them if none reports."""
        silent = all(isnan(self.numbers[speed]) for speed in part)
        return [
            self.is_not(speed, "below", below)
            for speed in part
            if silent or abs(self.numbers[speed]) >= below
        ]

    def is_not(self, signal: int, relation: str, limit: float) -> str:
        """Return ``SIGNAL is 12.0 deg, not at 28.0 deg``, or that it is unknown and why."""
        name, value = self._robot.vocabulary.numbers[signal], self.numbers[signal]
        if isnan(value):
            return f"{name} is unknown{self._why_unknown(signal)}"
        limit_text = self._written(signal, limit)
        return f"{name} is {self._written(signal, value)}, not {relation} {limit_text}"

    def _why_unknown(self, signal: int) -> str:
        if signal in self._sensing.doubted:
            return " (the values of its sensor are implausible)"
        boards = self._robot.boards.values()
        silent = any(
            signal in board.number_set and board.position in self._sensing.stale for board in boards
        )
        return " (its board does not report)" if silent else ""

    def _written(self, signal: int, value: float) -> str:
        kind = self._robot.vocabulary.types[self._robot.vocabulary.numbers[signal]]
        assert isinstance(kind, NumberType)  # it stands among the numbers
        factor, form, unit = _IN_WORDS.get(kind.dimension, (1.0, ".3g", f" {kind.dimension}"))
        return f"{value * factor:z{form}}{unit}".rstrip()
