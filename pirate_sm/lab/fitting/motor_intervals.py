"""Finds what each motor of a recorded robot did between two readings."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pirate_sm.core.models import Motor, Profile, Slot
from pirate_sm.core.models import signals as kinds
from pirate_sm.lab.fitting.measurements import Columns, MeasuredFile, column
from pirate_sm.running.recording.tables import TIME
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.electronics import scale_of

_SETTLED_S = 0.3
"""How long after a setpoint has changed it is surely active."""

_UNEVEN = 0.2
_LONGEST_S = 0.5
"""Readings that lie farther apart say nothing of what was between them."""

_DEVIATIONS = 1.4826
"""Standard deviations in a median magnitude of what is normally distributed."""


class Intervals(NamedTuple):
    """Between two readings of a motor, at the same duty.

    Attributes:
        duty: −1 to 1.
        rate: Of the motor at the joint or wheel, rad/s, positive with the duty.
        load: Torque against the duty, Nm; of wheels, and at duty 0, its magnitude.
        change: Between the two readings of the load, Nm.
    """

    duty: Floats
    rate: Floats
    load: Floats
    change: Floats

    @property
    def noise_nm(self) -> float:
        """Return the standard deviation of a reading of the load, from its median change."""
        if not len(self.change):
            return 0.0
        return float(np.median(np.abs(self.change))) * _DEVIATIONS / 2**0.5


def intervals_of(
    measured: MeasuredFile, profile: Profile, name: str, motor: Motor
) -> list[Intervals]:
    """Return the intervals of every slot with this kind of motor that reports."""
    slots = [slot for slot in profile.slots if slot.motor == name]
    found = (_of_slot(measured, profile, slot, motor) for slot in slots)
    return [each for each in found if each is not None]


def _of_slot(
    measured: MeasuredFile, profile: Profile, slot: Slot, motor: Motor
) -> Intervals | None:
    signals = load_signals(profile, slot)
    if signals is None or slot.name not in measured.setpoints:
        return None
    angle_name, load_name, scale = signals
    columns = measured.columns
    angle = column(columns, angle_name)
    load: Floats = np.multiply(column(columns, load_name), scale, dtype=np.float64)
    known = np.isfinite(angle) & np.isfinite(load)
    moved = (np.diff(np.nan_to_num(each)) != 0 for each in (angle, load))
    fresh = np.concatenate([[True], np.logical_or(*moved)]) & known  # else another board's frame
    times, angle, load = columns[TIME][fresh], angle[fresh], load[fresh]
    if motor.kind == "sprung_worm":
        angle = np.add(angle, load / (motor.stiffness or np.inf), dtype=np.float64)
    if len(times) < 4:
        return None
    duty = duties(measured.setpoints, slot.name, times)
    spans = np.diff(times)
    good = (spans < _LONGEST_S) & np.isfinite(duty[1:]) & (duty[1:] == duty[:-1])
    rate, change = np.diff(angle) / spans, np.diff(load)
    load = _means(load, spans, good if motor.kind == "sprung_worm" else np.zeros_like(good))
    # Which way an angle counts is the profile's business: a motor turns with its duty.
    way = np.sign(np.sum((rate * duty[1:])[good])) or 1.0
    turned = np.sign(duty[1:]) * way
    if motor.kind == "geared":
        load = np.abs(load)
    else:
        load = np.where(duty[1:] == 0, np.abs(load), load * turned)
    rate = np.where(duty[1:] == 0, np.abs(rate), rate * turned)
    return Intervals(np.abs(duty[1:][good]), rate[good], load[good], change[good])


def _means(load: Floats, spans: Floats, good: NDArray[np.bool_]) -> Floats:
    """Return the mean load of each interval, by the readings at its ends and next to them.

    A spring is wound in a curve: the mean of the ends is too small. Where readings are evenly
    spaced and ``good``, a cubic through four of them has the mean (13 (b + c) - a - d) / 24.
    """
    means: Floats = (load[1:] + load[:-1]) / 2
    even = np.abs(np.diff(spans)) < _UNEVEN * spans[1:]
    curved = good[1:-1] & good[:-2] & good[2:] & even[:-1] & even[1:]
    cubic = (13 * (load[1:-2] + load[2:-1]) - load[:-3] - load[3:]) / 24
    means[1:-1] = np.where(curved, cubic, means[1:-1])
    return means


def load_signals(profile: Profile, slot: Slot) -> tuple[str, str, float] | None:
    """Return the signals with angle and load of a slot's motor, and Nm per unit of the load."""
    if slot.wheel is not None:
        wheel = next(each for each in profile.body.wheels if each.name == slot.wheel)
        for each in profile.derived.values():
            if isinstance(each, kinds.TorqueOf) and each.slot == slot.name:
                return wheel.angle, each.torque_of, scale_of(each.scale)
        return None
    joint = next((each for each in profile.body.joints if each.name == slot.joint), None)
    return (joint.name, joint.torque, 1.0) if joint is not None and joint.torque else None


def duties(setpoints: Columns, slot: str, times: Floats) -> Floats:
    """Return the active duty at each time; NaN shortly after it has changed."""
    sent, values = setpoints[TIME], setpoints[slot]
    changed = np.concatenate([[True], np.diff(values) != 0])
    sent, values = sent[changed], values[changed]
    at = np.searchsorted(sent, times, side="right") - 1
    settled = (at >= 0) & (times - sent[np.maximum(at, 0)] > _SETTLED_S)
    duties: Floats = np.where(settled, values[np.maximum(at, 0)], np.nan)
    return duties
