"""Estimates the numbers of a robot that nobody measured, from a recording of it.

A motor turns with ω0 (u − τ / τ_stall): with duty u, load τ, speed without load ω0. Of a joint
behind a spring that is the motor's side, γ + τ / K. Two readings give an equation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pirate_sm.fitting.columns import Columns, Measured, column, has
from pirate_sm.fitting.slip_columns import SlipSignals
from pirate_sm.fitting.slip_curve import Estimate
from pirate_sm.model import derived as kinds
from pirate_sm.model.motor import Motor
from pirate_sm.model.profile import Profile, Slot
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.sensors import scale_of

_SETTLED_S = 0.3
"""How long after a setpoint has changed it is surely in force."""

_LONGEST_S = 0.5
_MOVES_RAD_S = 0.1
_TURNED_RAD_S, _TURNED_SHARE = 0.3, 0.75
"""A wheel at duty 0 that turns faster is turned against its gears. It may have stood still for a
part of an interval and borne less then: so the upper quartile counts, not the median."""

_LEAST = 15
"""Fewer intervals say nothing."""

_DRAWS, _BLOCKS = 200, 20
_MOST_WIDTH = 0.5
"""A 95 % interval that is wider, as a share of the value, tells that the data do not know it."""


@dataclass(frozen=True)
class RobotNumber:
    """A number of the robot.

    Attributes:
        motor: Kind of motor; empty for friction.
        key: Its key in the profile, or what it is.
        unit: Its SI unit.
        estimate: What the recording says.
    """

    motor: str
    key: str
    unit: str
    estimate: Estimate


class _Intervals(NamedTuple):
    """Between two readings of a motor, in force the same duty.

    Attributes:
        duty: −1 to 1.
        rate: Of the motor at the joint or wheel, rad/s, positive with the duty.
        load: Torque against the duty, Nm; at duty 0 its magnitude.
    """

    duty: Floats
    rate: Floats
    load: Floats


def robot_numbers(measured: Sequence[Measured]) -> list[RobotNumber]:
    """Return what the recordings say of the motors and of friction, with what they cannot say."""
    profile = next(each.profile for each in measured if each.profile is not None)
    found: list[RobotNumber] = []
    for name, motor in profile.motors.items():
        if motor.kind in ("geared", "sprung_worm"):
            parts = [_of_motor(each, profile, name, motor) for each in measured]
            found += _motor_numbers(name, motor, [one for part in parts for one in part])
    return [*found, *_frictions(measured, profile)]


def _of_motor(measured: Measured, profile: Profile, name: str, motor: Motor) -> list[_Intervals]:
    """Return the intervals of every slot with this kind of motor that reports."""
    slots = [slot for slot in profile.slots if slot.motor == name]
    found = (_intervals(measured, profile, slot, motor) for slot in slots)
    return [each for each in found if each is not None]


def _intervals(measured: Measured, profile: Profile, slot: Slot, motor: Motor) -> _Intervals | None:
    signals = _signals(profile, slot)
    if signals is None or slot.name not in measured.setpoints:
        return None
    angle_name, load_name, scale = signals
    columns = measured.columns
    angle = column(columns, angle_name)
    load: Floats = np.multiply(column(columns, load_name), scale, dtype=np.float64)
    known = np.isfinite(angle) & np.isfinite(load)
    fresh = np.concatenate([[True], np.diff(np.nan_to_num(angle)) != 0]) & known
    times, angle, load = columns["time_s"][fresh], angle[fresh], load[fresh]
    if motor.kind == "sprung_worm":
        angle = np.add(angle, load / (motor.stiffness or np.inf), dtype=np.float64)
    if len(times) < 3:
        return None
    duty = _duties(measured.setpoints, slot.name, times)
    spans = np.diff(times)
    good = (spans < _LONGEST_S) & np.isfinite(duty[1:]) & (duty[1:] == duty[:-1])
    rate, load = np.diff(angle) / spans, (load[1:] + load[:-1]) / 2
    # Which way an angle counts is the profile's business: a motor turns with its duty.
    way = np.sign(np.sum((rate * duty[1:])[good])) or 1.0
    turned = np.sign(duty[1:]) * way
    if motor.kind == "geared":
        load = np.abs(load)
    else:
        load = np.where(duty[1:] == 0, np.abs(load), load * turned)
    rate = np.where(duty[1:] == 0, np.abs(rate), rate * turned)
    return _Intervals(np.abs(duty[1:][good]), rate[good], load[good])


def _signals(profile: Profile, slot: Slot) -> tuple[str, str, float] | None:
    """Return the signals with angle and load of a slot's motor, and Nm per unit of the load."""
    if slot.wheel is not None:
        wheel = next(each for each in profile.body.wheels if each.name == slot.wheel)
        for each in profile.derived.values():
            if isinstance(each, kinds.TorqueOf) and each.slot == slot.name:
                return wheel.angle, each.torque_of, scale_of(each.scale)
        return None
    joint = next((each for each in profile.body.joints if each.name == slot.joint), None)
    return (joint.name, joint.torque, 1.0) if joint is not None and joint.torque else None


def _duties(setpoints: Columns, slot: str, times: Floats) -> Floats:
    """Return the duty in force at each time; NaN shortly after it has changed."""
    sent, values = setpoints["time_s"], setpoints[slot]
    changed = np.concatenate([[True], np.diff(values) != 0])
    sent, values = sent[changed], values[changed]
    at = np.searchsorted(sent, times, side="right") - 1
    settled = (at >= 0) & (times - sent[np.maximum(at, 0)] > _SETTLED_S)
    duties: Floats = np.where(settled, values[np.maximum(at, 0)], np.nan)
    return duties


def _motor_numbers(name: str, motor: Motor, parts: list[_Intervals]) -> Iterator[RobotNumber]:
    """Yield what the intervals of all motors of a kind say."""
    if not parts:
        unknown = Estimate(reason="no motor of this kind reports its angle and its load")
        yield RobotNumber(name, "no_load_speed", "rad/s", unknown)
        return
    all_ = _Intervals(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    driven = (all_.duty > 0) & (all_.rate > _MOVES_RAD_S) & (all_.load >= 0)
    rows = np.column_stack([all_.duty[driven], -all_.load[driven], all_.rate[driven]])
    yield RobotNumber(name, "no_load_speed", "rad/s", _estimate(rows, _speed, "it hardly moved"))
    yield RobotNumber(name, "stall_torque", "Nm", _estimate(rows, _stall, "its load hardly varied"))
    if motor.kind == "geared":
        yield RobotNumber(name, "hold_torque", "Nm", _hold(all_))


def _speed(rows: Floats) -> float:
    return float(_solved(rows)[0])


def _stall(rows: Floats) -> float:
    speed, slope = _solved(rows)
    return float(speed / slope) if slope > 0 else np.nan


def _solved(rows: Floats) -> Floats:
    """Return ω0 and ω0 / τ_stall by least squares."""
    solution = np.linalg.lstsq(rows[:, :2], rows[:, 2], rcond=None)[0]
    return np.asarray(solution, dtype=np.float64)


def _hold(all_: _Intervals) -> Estimate:
    """Return the torque of wheels that were turned at duty 0; a bound where none was."""
    braked = all_.duty == 0
    turned = braked & (all_.rate > _TURNED_RAD_S)
    loads = all_.load[turned]
    if np.count_nonzero(turned) < _LEAST:
        bound = float(np.quantile(all_.load[braked], 0.99)) if braked.any() else np.nan
        return Estimate(low=bound, reason="no wheel was turned against its gears at duty 0")
    return _estimate(loads[:, None], lambda rows: float(np.quantile(rows, _TURNED_SHARE)), "")


def _estimate(rows: Floats, statistic: Callable[[Floats], float], reason: str) -> Estimate:
    """Return a statistic with its interval, from draws of whole stretches of the recording."""
    if len(rows) < _LEAST:
        return Estimate(reason=f"{len(rows)} intervals, {_LEAST} are needed: {reason}")
    random = np.random.default_rng(0)
    stretches = np.array_split(rows, min(_BLOCKS, len(rows) // 3))
    drawn = [
        statistic(np.concatenate([stretches[i] for i in picked]))
        for picked in random.integers(len(stretches), size=(_DRAWS, len(stretches)))
    ]
    value = statistic(rows)
    low, high = (float(each) for each in np.nanquantile(drawn, [0.025, 0.975]))
    if not np.isfinite(value) or high - low > _MOST_WIDTH * abs(value):
        return Estimate(reason=f"between {low:.3g} and {high:.3g}: {reason}")
    return Estimate(value, low, high)


def _frictions(measured: Sequence[Measured], profile: Profile) -> Iterator[RobotNumber]:
    """Yield kinetic friction of each part, where the profile derives it for its wheels."""
    names = [wheel.name for wheel in profile.body.wheels]
    signals = SlipSignals(radius_m=profile.body.wheel_radius)
    for part in profile.body.parts:
        numbers = [
            str(names.index(wheel.name) + 1) for wheel in profile.body.wheels if wheel.part == part
        ]
        rows = [
            _known_friction(each.columns, number, signals)
            for each in measured
            for number in numbers
            if has(each.columns, [signals.known.format(number), signals.torque.format(number)])
        ]
        yield RobotNumber("", f"kinetic friction, {part}", "", _kinetic(rows))


def _known_friction(columns: Columns, number: str, signals: SlipSignals) -> Floats:
    """Return rows of friction and the torque with which a wheel slipped, where it is known."""
    friction = column(columns, signals.known.format(number))
    torque = np.abs(column(columns, signals.torque.format(number)))
    known = np.isfinite(friction) & np.isfinite(torque)
    rows: Floats = np.column_stack([friction[known], torque[known]])
    return rows


def _kinetic(rows: Sequence[Floats]) -> Estimate:
    if not rows:
        return Estimate(reason="the profile derives no friction of these wheels")
    return _estimate(np.concatenate(rows), _weighted_median, "no wheel slipped steadily")


def _weighted_median(rows: Floats) -> float:
    """Return the median of friction, each weighed by its torque: a wheel in the air bears none."""
    order = np.argsort(rows[:, 0])
    weight = np.cumsum(rows[order, 1])
    return float(rows[order[np.searchsorted(weight, weight[-1] / 2)], 0])
