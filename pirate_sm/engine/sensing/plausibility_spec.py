"""What is known beforehand of the sensors that are judged: limits, rates and thresholds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple


class WatchSpec(NamedTuple):
    """What is known beforehand of a sensor that measures a motor, SI.

    Attributes:
        number: Index of its number.
        name: For people.
        numbers: Indexes of the numbers that rest on it, its own included.
        low: Least value that it can have; ``high`` the largest.
        rate: Fastest change per second; ``slack`` is allowed besides at any time.
        moved: A change that is a motion; infinite where it does not measure one.
        slot: Index of the setpoint of its motor.
        joint: Whether it is the angle of a joint, which cannot begin anew as a counter can.
        least_duty: Below it, what it measures may stand still though driven.
        load: Index of the current of the same motor; -1 where that is not measured.
        full_load: That current when the motor is stalled at full duty.
        torque: Index of the torque of the spring behind the motor; -1 where that is not measured.
        stiffness: Of that spring, per unit of the angle.
        turns: Speed of the motor without load.
        unit: In which people read it; ``per_unit`` is SI per unit.
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
    turns: float = 0.0
    unit: str = ""
    per_unit: float = 1.0

    def in_words(self, value: float) -> str:
        """Return the value as people read it."""
        return f"{value / self.per_unit:.3g} {self.unit}".strip()


@dataclass(frozen=True)
class WatchedSpec:
    """Sensors of one board, and what must be looked up in every frame."""

    sensors: tuple[WatchSpec, ...] = ()

    @cached_property
    def ranges(self) -> tuple[tuple[int, float, float], ...]:
        """Return number index, least and largest value of the sensors that have a range."""
        return tuple((w.number, w.low, w.high) for w in self.sensors if w.high < inf)

    @cached_property
    def rates(self) -> tuple[tuple[int, float, float], ...]:
        """Return number index, fastest change per second and slack of those that have a rate."""
        return tuple((w.number, w.rate, w.slack) for w in self.sensors if w.rate < inf)

    @cached_property
    def moving(self) -> tuple[tuple[int, int, float], ...]:
        """Return place, slot and least duty of those that measure a motion."""
        sensors = enumerate(self.sensors)
        return tuple((at, w.slot, w.least_duty) for at, w in sensors if w.moved < inf)


class PlausibilitySpec(NamedTuple):
    """Thresholds of all sensors; as in :class:`pirate_sm.model.plausibility.Plausibility`."""

    hold_back: int
    spikes: int
    spikes_within_s: float
    stuck_after_s: float
    unloaded: float
    settle_s: float
    moved_readings: int
