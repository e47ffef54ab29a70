"""Limits, rates and thresholds for judging the plausibility of sensors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

from pirate_sm.core._model.events import FaultReport
from pirate_sm.core._model.fault_codes import BuiltInFault


class WatchSpec(NamedTuple):
    """Limits of a sensor that measures a motor, in SI units.

    Attributes:
        number: Index of its number.
        name: Name for messages.
        numbers: Indexes of the numbers that depend on it, including its own.
        low: Smallest possible value; ``high``: the largest.
        rate: Fastest change per second but for the unwinding of its spring; ``slack`` is allowed
            in addition.
        moved: Smallest change that counts as motion; infinite if it measures no motion.
        slot: Index of the setpoint of its motor.
        joint: Whether it is the angle of a joint, which cannot restart as a counter can.
        least_duty: Below this duty the motor may stand still although driven.
        load: Index of the current of the same motor; -1 if it is not measured.
        full_load: That current when the motor stalls at full duty.
        torque: Index of the torque of the spring behind the motor; -1 if it is not measured.
        stiffness: Stiffness of that spring, per unit of the angle; ``spring`` is the share by which
            it may differ.
        winds: Torque to which the motor can wind it up.
        unit: Unit for messages; ``per_unit`` is its SI value.
        of: The joint or wheel of the motor.
    """

    number: int
    name: str
    numbers: tuple[int, ...]
    low: float = -inf
    high: float = inf
    rate: float = inf
    slack: float = 0.0
    moved: float = inf
    slot: int = -1
    joint: bool = False
    least_duty: float = inf
    load: int = -1
    full_load: float = 0.0
    torque: int = -1
    stiffness: float = inf
    spring: float = 0.0
    winds: float = inf
    unit: str = ""
    per_unit: float = 1.0
    of: str = ""

    def report(self, fault: BuiltInFault, message: str) -> FaultReport:
        """Return a report of a fault of this sensor."""
        return fault.report(message, of=(self.of,) if self.of else ())

    @property
    def can_be(self) -> tuple[BuiltInFault, ...]:
        """Return the faults that this sensor can have, but for silence."""
        has = {
            BuiltInFault.SENSOR_RANGE: self.high < inf,
            BuiltInFault.SENSOR_SPIKING: self.high < inf or self.rate < inf,
            BuiltInFault.SENSOR_JUMPED: self.joint,
            BuiltInFault.SENSOR_STUCK: self.moved < inf and self.load >= 0,
            BuiltInFault.MOTION_UNASKED: self.moved < inf,
        }
        return tuple(fault for fault, can in has.items() if can)

    def in_words(self, value: float) -> str:
        """Return the value in its unit for messages."""
        return f"{value / self.per_unit:.3g} {self.unit}".strip()


@dataclass(frozen=True)
class WatchedSpec:
    """The watched sensors of one board, with lookup tables for every frame."""

    sensors: tuple[WatchSpec, ...] = ()

    @cached_property
    def ranges(self) -> tuple[tuple[int, float, float], ...]:
        """Return number index, smallest and largest value of the sensors with a range."""
        return tuple((w.number, w.low, w.high) for w in self.sensors if w.high < inf)

    @cached_property
    def rates(self) -> tuple[tuple[int, float, float], ...]:
        """Return number index, fastest change per second and slack of the sensors with a rate."""
        return tuple((w.number, w.rate, w.slack) for w in self.sensors if w.rate < inf)

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """Return the places of the sensors that measure a motion."""
        return tuple(place for place, watch in enumerate(self.sensors) if watch.moved < inf)


class PlausibilitySpec(NamedTuple):
    """Thresholds of all sensors; as in :class:`pirate_sm.core._model.plausibility.Plausibility`."""

    hold_back: int
    spikes: int
    spikes_within_s: float
    stuck_after_s: float
    unloaded: float
    settle_s: float
    moved_readings: int
    repeats_s: float
