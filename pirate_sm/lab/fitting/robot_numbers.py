"""Estimates the numbers of a robot that nobody measured, from a recording of it.

A motor turns with ω0 (u − τ / τ_stall): with duty u, load τ, speed without load ω0. Of a joint
behind a spring that is the motor's side, γ + τ / K. Two readings give an equation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pirate_sm.core.models import Motor, Profile, Slot
from pirate_sm.core.models import signals as kinds
from pirate_sm.lab.fitting.measurements import (
    DRAWS,
    Columns,
    Estimate,
    MeasuredFile,
    SlipSignalNames,
    column,
    estimate_of,
    has,
)
from pirate_sm.lab.fitting.traction_again import signals_with
from pirate_sm.running.recording.tables import TIME
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.electronics import scale_of

# --- what motors did -----------------------------------------------------------------------------


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
    times, angle, load = columns["time_s"][fresh], angle[fresh], load[fresh]
    if motor.kind == "sprung_worm":
        angle = np.add(angle, load / (motor.stiffness or np.inf), dtype=np.float64)
    if len(times) < 4:
        return None
    duty = _duties(measured.setpoints, slot.name, times)
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


def _duties(setpoints: Columns, slot: str, times: Floats) -> Floats:
    """Return the active duty at each time; NaN shortly after it has changed."""
    sent, values = setpoints["time_s"], setpoints[slot]
    changed = np.concatenate([[True], np.diff(values) != 0])
    sent, values = sent[changed], values[changed]
    at = np.searchsorted(sent, times, side="right") - 1
    settled = (at >= 0) & (times - sent[np.maximum(at, 0)] > _SETTLED_S)
    duties: Floats = np.where(settled, values[np.maximum(at, 0)], np.nan)
    return duties


# --- numbers -------------------------------------------------------------------------------------


_MOVES_RAD_S = 0.1
_MOVING_SHARE, _ROUNDS = 0.2, 4
"""A motor counts from this share of its speed without load on, by what the round before fitted."""

_NOISE = 5.0
"""Up to this many standard deviations a load may be noise alone. They are seen in its changes,
which are smaller near zero, where the sign is missing: by the factor 0.6."""

_STATICS = 0.05
"""Error of normal forces by the statics of the chain, and so of friction (docs/measurements.md);
one error of all parts, which have the same statics."""

_QUIET = 2.0
"""So many standard deviations a torque of rolling may be noise alone: nearly all of it is less."""

_ROLLS = 0.5
"""A wheel that turns at less than this share of its speed without load does more than roll
[assumed]."""

_PRESSED = 0.3
"""Error of the sum of normal forces by the statics of a chain that has driven: twice the 15 % that
simulators may differ by [assumed]. Of one that stands it is a factor (docs/decisions/0123)."""

_TURNED_RAD_S, _TURNED_SHARE = 0.3, 0.75
"""A wheel at duty 0 that turns faster is turned against its gears. It may have stood still for a
part of an interval and borne less then: so the upper quartile counts. Noise raises that, so the
interval reaches down to the median."""

_FRICTION, ROLLING = "kinetic friction", "rolling resistance"
_ONE_WAY = "it did not roll steadily on all wheels, both ways"
_STILL, _STEADY = "it hardly moved", "its load hardly varied"

_STANDS_RAD_S, _ALL_BUT = 0.02, 0.05
"""A joint that stands turns no faster than this, the noise of 0.05 deg in 0.1 s [assumed]. In this
share of the intervals it bears less than the threshold."""

_LEAST = 15
"""Fewer intervals say nothing."""

_MOST_WIDTH = 0.5
"""If a 95 % interval is a larger share of the value, the data do not determine it."""


@dataclass(frozen=True)
class RobotNumber:
    """A number of the robot.

    Attributes:
        motor: Kind of motor; empty for friction, and for what no simulator takes.
        key: Its key in the profile, or what it is.
        unit: Its SI unit.
        estimate: What the recording says.
    """

    motor: str
    key: str
    unit: str
    estimate: Estimate

    @property
    def is_friction(self) -> bool:
        """Whether it is friction of a part."""
        return self.key.startswith(_FRICTION)


def robot_numbers(measured: Sequence[MeasuredFile], stream: int = 0) -> list[RobotNumber]:
    """Return what the recordings say of the motors and of friction, with what they cannot say.

    Args:
        measured: Recordings of one robot.
        stream: As :func:`estimate_of` takes it. Errors of the method are drawn alike in all.
    """
    profile = next(each.profile for each in measured if each.profile is not None)
    found, quiet_nm = list[RobotNumber](), 0.0
    for name, motor in profile.motors.items():
        if motor.kind in ("geared", "sprung_worm"):
            parts = [one for each in measured for one in intervals_of(each, profile, name, motor)]
            found += _motor_numbers(name, motor, parts, stream)
            if motor.kind == "geared":
                quiet_nm = _QUIET * max((each.noise_nm for each in parts), default=0.0)
    shown = [_with_motors(each, profile, found) for each in measured]
    speeds = {name: motor.no_load_speed or np.nan for name, motor in profile.motors.items()}
    for each in found:
        if each.key == "no_load_speed" and each.estimate.known:
            speeds[each.motor] = each.estimate.high
    rolling = [_resisted(each, profile, speeds, quiet_nm) for each in shown]
    resistance = rolling_resistance(np.concatenate(rolling), stream)
    return [*found, *_frictions(shown, profile, stream), RobotNumber("", ROLLING, "", resistance)]


def _with_motors(
    measured: MeasuredFile, profile: Profile, found: Sequence[RobotNumber]
) -> MeasuredFile:
    """Return what was measured, with friction by the motors as they were found."""
    known = [each for each in found if each.estimate.known]
    if measured.recording is None or not known or not _shows_friction(measured.columns):
        return measured
    motors = {
        name: motor.model_copy(
            update={each.key: each.estimate.value for each in known if each.motor == name}
        )
        for name, motor in profile.motors.items()
    }
    columns = signals_with(measured.recording, motors)
    return measured if columns is None else measured.with_columns(columns)


def _shows_friction(columns: Columns) -> bool:
    """Return whether the friction of a wheel is known anywhere."""
    prefix = SlipSignalNames().known.format("")
    known = (values for name, values in columns.items() if name.startswith(prefix))
    return any(bool(np.isfinite(values).any()) for values in known)


def _motor_numbers(
    name: str, motor: Motor, parts: list[Intervals], stream: int
) -> Iterator[RobotNumber]:
    """Yield what the intervals of all motors of a kind say."""
    if not parts:
        unknown = Estimate(reason="no motor of this kind reports its angle and its load")
        yield RobotNumber(name, "no_load_speed", "rad/s", unknown)
        return
    all_ = Intervals(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    rows = driven(all_)
    if motor.kind == "geared":
        yield from wheel_numbers(name, rows, all_, stream)
        return
    stall = _estimate(rows, _stall, _STEADY, stream)
    yield RobotNumber(name, "no_load_speed", "rad/s", _estimate(rows, _speed, _STILL, stream))
    yield RobotNumber(name, "stall_torque", "Nm", stall)
    yield RobotNumber("", f"clamp threshold, {name}", "", clamp_threshold(all_, stall))


def clamp_threshold(all_: Intervals, stall: Estimate) -> Estimate:
    """Return the share of what its motor gives that a standing joint bears nearly always.

    A clamp that counts from a larger share on (`share` in a profile) may never be confirmed: in
    the thesis joints bore 0.16 to 1.92 Nm where their motors should give 0.7 (section 7-1-1).
    """
    standing = (all_.duty > 0) & (all_.load > 0) & (np.abs(all_.rate) < _STANDS_RAD_S)
    if not stall.known:
        return Estimate(reason="it is a share of a stall torque that is unknown")
    shares = all_.load[standing] / (all_.duty[standing] * stall.value)
    found = _estimate(shares[:, None], _nearly_always, "no joint stood against its motor")
    wide = stall.high / stall.value, stall.low / stall.value
    return replace(found, low=found.low / wide[0], high=found.high / wide[1])


def _nearly_always(shares: Floats) -> float:
    return float(np.quantile(shares, _ALL_BUT))


def wheel_numbers(
    name: str, rows: Floats, all_: Intervals, stream: int = 0
) -> Iterator[RobotNumber]:
    """Yield the numbers of a motor whose current has no sign, so that noise adds to its load.

    A load within the noise counts as none. The interval is also that of the load as it was read:
    of such a small one it cannot be known.
    """
    none = np.abs(rows[:, 1]) <= _NOISE * all_.noise_nm
    quiet = rows * np.where(none[:, None], [1.0, 0.0, 1.0], 1.0)
    for key, unit, statistic, reason in (
        ("no_load_speed", "rad/s", _speed, _STILL),
        ("stall_torque", "Nm", _stall, _STEADY),
    ):
        read, found = (_estimate(each, statistic, reason, stream) for each in (rows, quiet))
        yield RobotNumber(name, key, unit, _spanned(found, read, 1))
    yield RobotNumber(name, "hold_torque", "Nm", _hold(all_, stream))


def _spanned(found: Estimate, other: Estimate, stream: int) -> Estimate:
    """Return an estimate whose interval is also that of another one, if both are known.

    Its draws lie anywhere between theirs; numbers with the same error have the same stream.
    """
    if not (found.known and other.known):
        return found
    between = np.random.default_rng(stream).random(DRAWS) * (other.draws - found.draws)
    low, high = min(found.low, other.low), max(found.high, other.high)
    return replace(found, low=low, high=high, draws=found.draws + between)


def driven(all_: Intervals) -> Floats:
    """Return rows of duty, load with a minus, and rate of a motor that moves by its duty.

    What is near its stall is left out by its duty and load, not by its rate: of rates that are
    as small as their errors only the larger ones would be left.
    """
    against = (all_.duty > 0) & (all_.load >= 0)
    rows = np.column_stack([all_.duty, -all_.load, all_.rate])
    kept = against & (all_.rate > _MOVES_RAD_S)
    for _ in range(_ROUNDS):
        if np.count_nonzero(kept) < _LEAST:
            break
        expected = rows[:, :2] @ _solved(rows[kept])
        free = _speed(rows[kept]) * all_.duty
        kept = against & (all_.rate > 0) & (expected > _MOVING_SHARE * free)
    moving: Floats = rows[kept]
    return moving


def _speed(rows: Floats) -> float:
    return float(_solved(rows)[0])


def _stall(rows: Floats) -> float:
    speed, slope = _solved(rows)
    return float(speed / slope) if slope > 0 else np.nan


def _solved(rows: Floats) -> Floats:
    """Return ω0 and ω0 / τ_stall by least squares."""
    solution = np.linalg.lstsq(rows[:, :2], rows[:, 2], rcond=None)[0]
    return np.asarray(solution, dtype=np.float64)


def _hold(all_: Intervals, stream: int) -> Estimate:
    """Return the torque of wheels that were turned at duty 0; a bound where none was."""
    braked = all_.duty == 0
    turned = braked & (all_.rate > _TURNED_RAD_S)
    loads = all_.load[turned]
    if np.count_nonzero(turned) < _LEAST:
        bound = float(np.quantile(all_.load[braked], 0.99)) if braked.any() else np.nan
        return Estimate(low=bound, reason="no wheel was turned against its gears at duty 0")
    most = _estimate(
        loads[:, None], lambda rows: float(np.quantile(rows, _TURNED_SHARE)), "", stream
    )
    return _spanned(
        most, _estimate(loads[:, None], lambda rows: float(np.median(rows)), "", stream), 3
    )


def _estimate(
    rows: Floats, statistic: Callable[[Floats], float], reason: str, stream: int = 0
) -> Estimate:
    """Return a statistic with its interval; unknown where too little was recorded for it."""
    if len(rows) < _LEAST:
        return Estimate(reason=f"{len(rows)} intervals, {_LEAST} are needed: {reason}")
    found = estimate_of(rows, statistic, 3, stream)
    if not np.isfinite(found.value) or found.high - found.low > _MOST_WIDTH * abs(found.value):
        return Estimate(reason=f"between {found.low:.3g} and {found.high:.3g}: {reason}")
    return found


def _frictions(
    measured: Sequence[MeasuredFile], profile: Profile, stream: int
) -> Iterator[RobotNumber]:
    """Yield kinetic friction of each part, where the profile derives it for its wheels."""
    names = [wheel.name for wheel in profile.body.wheels]
    signals = SlipSignalNames(radius_m=profile.body.wheel_radius)
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
        yield RobotNumber("", f"{_FRICTION}, {part}", "", _kinetic(rows, stream))


def _known_friction(columns: Columns, number: str, signals: SlipSignalNames) -> Floats:
    """Return rows of friction and the torque with which a wheel slipped, where it is known."""
    friction = column(columns, signals.known.format(number))
    torque = np.abs(column(columns, signals.torque.format(number)))
    known = np.isfinite(friction) & np.isfinite(torque)
    rows: Floats = np.column_stack([friction[known], torque[known]])
    return rows


def _kinetic(rows: Sequence[Floats], stream: int) -> Estimate:
    if not rows:
        return Estimate(reason="the profile derives no friction of these wheels")
    found = _estimate(np.concatenate(rows), _weighted_median, "no wheel slipped steadily", stream)
    low, high = found.low * (1 - _STATICS), found.high * (1 + _STATICS)
    off = np.random.default_rng(2).uniform(1 - _STATICS, 1 + _STATICS, len(found.draws))
    return replace(found, low=low, high=high, draws=found.draws * off)


def _weighted_median(rows: Floats) -> float:
    """Return the median of friction, each weighed by its torque: a wheel in the air bears none."""
    order = np.argsort(rows[:, 0])
    weight = np.cumsum(rows[order, 1])
    return float(rows[order[np.searchsorted(weight, weight[-1] / 2)], 0])


# --- rolling resistance --------------------------------------------------------------------------


def _resisted(
    measured: MeasuredFile, profile: Profile, speeds: Mapping[str, float], quiet_nm: float
) -> Floats:
    """Return rows of what resists rolling while all wheels drive, over their normal forces.

    At a constant speed the forces along the pipe add up to zero: the motors bear what resists, and
    the weight, whose sign is another one on the way back. A current has no sign; the torque helps
    where a wheel surely turns faster than without load. In a row: with the torques as read,
    without those that may be noise, and which way it drives.
    """
    columns, rows = measured.columns, []
    rates = {each.rate_of: name for name, each in profile.derived.items()
             if isinstance(each, kinds.RateOf)}  # fmt: skip
    names = [wheel.name for wheel in profile.body.wheels]
    for slot in (each for each in profile.slots if each.wheel is not None):
        found = load_signals(profile, slot)
        normal = SlipSignalNames().normal.format(names.index(slot.wheel or "") + 1)
        if found is None or found[0] not in rates or slot.name not in measured.setpoints:
            return np.empty((0, 3))
        if not has(columns, [normal]):
            return np.empty((0, 3))
        duty = _duties(measured.setpoints, slot.name, columns[TIME])
        duty = np.where(duty == 0, np.nan, duty)
        share = np.abs(column(columns, rates[found[0]])) / speeds[slot.motor] / np.abs(duty)
        torque = np.abs(column(columns, found[1])) * abs(found[2]) * np.where(share < 1, 1, -1)
        torque = np.where(share > _ROLLS, torque, np.nan)
        quiet = np.where(np.abs(torque) > quiet_nm, torque, 0 * torque)
        rows.append((torque, quiet, np.abs(column(columns, normal))))
    if not rows:
        return np.empty((0, 3))
    torque, quiet, normal = np.sum(rows, axis=0)
    pressed = normal * profile.body.wheel_radius
    resisted: Floats = np.column_stack([torque / pressed, quiet / pressed, np.sign(duty)])
    return resisted[np.isfinite(resisted).all(axis=1)]


def rolling_resistance(rows: Floats, stream: int = 0) -> Estimate:
    """Return the mean of both ways; unknown where it is no more than the noise of currents."""
    if len(np.unique(rows[:, 2])) < 2:
        return Estimate(reason=_ONE_WAY)
    read, quiet = (_estimate(rows[:, [place, 2]], _both_ways, _ONE_WAY, stream) for place in (0, 1))
    if not read.known:
        return read
    if not quiet.value > read.value / 2:
        return Estimate(reason=f"at most {read.high:.3f}, within the noise of currents")
    found = _spanned(read, quiet, 4)
    off = np.random.default_rng(5).uniform(1 - _PRESSED, 1 + _PRESSED, len(found.draws))
    low, high = found.low * (1 - _PRESSED), found.high * (1 + _PRESSED)
    return replace(found, low=low, high=high, draws=found.draws * off)


def _both_ways(rows: Floats) -> float:
    forward = rows[:, 1] > 0
    if forward.all() or not forward.any():
        return np.nan
    return float(np.median(rows[forward, 0]) + np.median(rows[~forward, 0])) / 2
