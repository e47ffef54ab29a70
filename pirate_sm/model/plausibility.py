"""Limits of a robot's sensors; values beyond them are not believed."""

from __future__ import annotations

from math import radians
from typing import Annotated

from pydantic import Field

from pirate_sm.model.base import Frozen
from pirate_sm.model.quantities import Angle, Count, Duration, Number, Ratio

_Factor = Annotated[Number, Field(gt=0)]
_PositiveAngle = Annotated[Angle, Field(gt=0)]
_PositiveDuration = Annotated[Duration, Field(gt=0)]
_Readings = Annotated[Count, Field(ge=1)]


class Plausibility(Frozen):
    """Limits beyond which a sensor is wrong, whatever the robot does.

    Attributes:
        overspeed: An angle changes at most this many times as fast as its motor turns without load,
            for others may push it.
        joint_slack: A joint may change by this much more between two readings.
        wheel_slack: A wheel may change by this much more between two readings.
        beyond_stop: A joint's angle may be so far beyond its end stop.
        overcurrent: A current may be so many times that of the stalled motor.
        overtorque: A torque may be so many times that of the stalled motor, for a spring behind a
            self-locking gear can be wound up from outside.
        hold_back: An impossible value is replaced by the last believed one for this many readings.
        spikes: So many spikes of one sensor within ``spikes_within`` are a fault.
        spikes_within: The time in which spikes are counted.
        stuck_after: A sensor is stuck when it shows the same value for this long while its motor is
            driven and bears no load.
        unloaded: A motor bears no load below this share of the current that it would draw stalled
            at the same duty cycle.
        surely_driven: A motor surely turns above this many times the least duty cycle of its
            position loop.
        settle: Nothing moves any more this long after the last change of a setpoint.
        joint_moved: A joint that changes by more than this has moved.
        wheel_moved: A wheel that changes by more than this has moved.
        moved_readings: So many readings in a row must show a motion that was not asked for.
    """

    overspeed: _Factor = 3.0
    joint_slack: _PositiveAngle = radians(6)
    wheel_slack: _PositiveAngle = 1.0
    beyond_stop: _PositiveAngle = radians(12)
    overcurrent: _Factor = 2.0
    overtorque: _Factor = 8.0
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
