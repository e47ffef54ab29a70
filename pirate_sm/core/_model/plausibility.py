"""Limits of a robot's sensors; values beyond them are not believed."""

from __future__ import annotations

from math import radians
from typing import Annotated

from pydantic import Field

from pirate_sm.core._model.base import Frozen
from pirate_sm.core._model.quantities import Acceleration, Angle, Count, Duration, Number, Ratio

_Factor = Annotated[Number, Field(gt=0)]
_PositiveAngle = Annotated[Angle, Field(gt=0)]
_PositiveDuration = Annotated[Duration, Field(gt=0)]
_Readings = Annotated[Count, Field(ge=1)]


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

    overspeed: _Factor = 3.0
    joint_slack: _PositiveAngle = radians(6)
    wheel_slack: _PositiveAngle = 1.0
    beyond_stop: _PositiveAngle = radians(12)
    overcurrent: _Factor = 2.0
    overtorque: _Factor = 8.0
    acceleration: Annotated[Acceleration, Field(gt=0)] | None = None
    hold_back: Count = 2
    spikes: _Readings = 5
    spikes_within: _PositiveDuration = 10.0
    stuck_after: _PositiveDuration = 1.5
    unloaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.4
    surely_driven: _Factor = 1.5
    settle: _PositiveDuration = 1.5
    joint_moved: _PositiveAngle = radians(20)
    wheel_moved: _PositiveAngle = 1.0
    moved_readings: _Readings = 2
    spring: Annotated[Ratio, Field(ge=0, lt=1)] = 0.0
    repeats: _PositiveDuration = 0.2
