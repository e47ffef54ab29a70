"""Limits beyond which a sensor is wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import radians
from typing import Annotated, Literal

from pydantic import Field

from pirate_sm.core._model.base import Frozen
from pirate_sm.core._model.quantities import (
    Acceleration,
    Angle,
    Count,
    Number,
    PositiveDuration,
    Ratio,
)
from pirate_sm.core._model.robot.body import Motor

Bounded = Literal["value", "rate"]

_Factor = Annotated[Number, Field(gt=0)]
_Acceleration = Annotated[Acceleration, Field(gt=0)]
_PositiveAngle = Annotated[Angle, Field(gt=0)]
_Readings = Annotated[Count, Field(ge=1)]


@dataclass(frozen=True, slots=True)
class Limit:
    """What a key is a limit of: either way, the value or the rate of what sensors show.

    Attributes:
        bounds: What it bounds.
        senses: What these sensors sense, or the beginning of that.
        times: The number of their motor that the key is a multiple of; empty for none.

    It annotates the whole type of its key, ``None`` included.
    """

    bounds: Bounded
    senses: str
    times: str = ""

    def __post_init__(self) -> None:
        """Refuse a multiple of a number that motors do not have."""
        if self.times and self.times not in Motor.model_fields:
            raise TypeError(f"motors have no number '{self.times}'")


class Plausibility(Frozen):
    """Limits beyond which a sensor is wrong in any situation.

    Attributes:
        overspeed: Largest speed of an angle as a multiple of the no-load speed of its motor; other
            motors may push it. A joint whose spring's torque is measured has no such allowance.
        joint_slack: Additional change of a joint allowed between two readings.
        wheel_slack: Additional change of a wheel allowed between two readings.
        beyond_stop: How far a joint's angle may be beyond its end stop.
        overcurrent: Largest current as a multiple of the motor's stall current.
        overtorque: Largest torque as a multiple of the motor's stall torque; outside forces can
            wind up a spring behind a self-locking gear.
        acceleration: Largest magnitude of each number of an accelerometer; without one all are
            believed.
        hold_back: Number of readings for which the last believed value replaces an impossible one.
        spikes: Number of spikes of one sensor within ``spikes_within`` that is a fault.
        spikes_within: Duration in which spikes are counted.
        stuck_after: A sensor is stuck if it shows the same value for this long while its motor is
            driven without load.
        unloaded: A motor is without load below this share of its stall current at the same duty
            cycle.
        surely_driven: A motor certainly turns above this multiple of the least duty cycle of its
            position loop.
        settle: All motion ends within this time after the last change of a setpoint.
        joint_moved: Smallest change of a joint that counts as motion.
        wheel_moved: Smallest change of a wheel that counts as motion.
        moved_readings: Number of consecutive readings that must show an unexpected motion.
        spring: By this share a joint's spring may be stiffer or softer than its motor says.
        repeats: A joint may have turned for this long although its board repeats its angle.
    """

    overspeed: Annotated[_Factor, Limit("rate", "angle", "no_load_speed")] = 3.0
    joint_slack: _PositiveAngle = radians(6)
    wheel_slack: _PositiveAngle = 1.0
    beyond_stop: _PositiveAngle = radians(12)
    overcurrent: Annotated[_Factor, Limit("value", "current", "stall_current")] = 2.0
    overtorque: Annotated[_Factor, Limit("value", "torque", "stall_torque")] = 8.0
    acceleration: Annotated[_Acceleration | None, Limit("value", "acc")] = None
    hold_back: Count = 2
    spikes: _Readings = 5
    spikes_within: PositiveDuration = 10.0
    stuck_after: PositiveDuration = 1.5
    unloaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.4
    surely_driven: _Factor = 1.5
    settle: PositiveDuration = 1.5
    joint_moved: _PositiveAngle = radians(20)
    wheel_moved: _PositiveAngle = 1.0
    moved_readings: _Readings = 2
    spring: Annotated[Ratio, Field(ge=0, lt=1)] = 0.0
    repeats: PositiveDuration = 0.2

    def limits(self, senses: str, motor: Motor | None) -> Iterator[tuple[Bounded, float]]:
        """Yield what bounds a sensor, by what it senses and its motor, and the bound."""
        for key, field in type(self).model_fields.items():
            for limit in field.metadata:
                if isinstance(limit, Limit) and senses.startswith(limit.senses):
                    of = 1.0 if not limit.times else motor and getattr(motor, limit.times)
                    share = getattr(self, key)
                    if share is not None and of is not None:
                        yield limit.bounds, share * of
