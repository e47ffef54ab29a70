"""Estimates the numbers of a robot that nobody measured, from a recording of it.

A motor turns with ω0 (u − τ / τ_stall): with duty u, load τ, speed without load ω0. Of a joint
behind a spring that is the motor's side, γ + τ / K. Two readings give an equation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pirate_sm.core.profile import Motor, Profile
from pirate_sm.lab.fitting.columns import Columns, MeasuredFile, column, has
from pirate_sm.lab.fitting.estimate import Estimate, estimate_of
from pirate_sm.lab.fitting.friction_anew import signals_with
from pirate_sm.lab.fitting.motor_intervals import Intervals, intervals_of
from pirate_sm.lab.fitting.slip_columns import SlipSignalNames
from pirate_sm.simulation.arrays import Floats

_MOVES_RAD_S = 0.1
_MOVING_SHARE, _ROUNDS = 0.2, 4
"""A motor counts from this share of its speed without load on, by what the round before fitted."""

_NOISE = 5.0
"""Up to this many standard deviations a load may be noise alone. They are seen in its changes,
which are smaller near zero, where the sign is missing: by the factor 0.6."""

_STATICS = 0.05
"""Error of normal forces by the statics of the chain, and so of friction (docs/measurements.md)."""

_TURNED_RAD_S, _TURNED_SHARE = 0.3, 0.75
"""A wheel at duty 0 that turns faster is turned against its gears. It may have stood still for a
part of an interval and borne less then: so the upper quartile counts. Noise raises that, so the
interval reaches down to the median."""

_STILL, _STEADY = "it hardly moved", "its load hardly varied"

_LEAST = 15
"""Fewer intervals say nothing."""

_MOST_WIDTH = 0.5
"""If a 95 % interval is a larger share of the value, the data do not determine it."""


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


def robot_numbers(measured: Sequence[MeasuredFile]) -> list[RobotNumber]:
    """Return what the recordings say of the motors and of friction, with what they cannot say."""
    profile = next(each.profile for each in measured if each.profile is not None)
    found: list[RobotNumber] = []
    for name, motor in profile.motors.items():
        if motor.kind in ("geared", "sprung_worm"):
            parts = [intervals_of(each, profile, name, motor) for each in measured]
            found += _motor_numbers(name, motor, [one for part in parts for one in part])
    shown = [_with_motors(each, profile, found) for each in measured]
    return [*found, *_frictions(shown, profile)]


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
    return measured if columns is None else measured._replace(columns=columns)


def _shows_friction(columns: Columns) -> bool:
    """Return whether the friction of a wheel is known anywhere."""
    prefix = SlipSignalNames().known.format("")
    known = (values for name, values in columns.items() if name.startswith(prefix))
    return any(bool(np.isfinite(values).any()) for values in known)


def _motor_numbers(name: str, motor: Motor, parts: list[Intervals]) -> Iterator[RobotNumber]:
    """Yield what the intervals of all motors of a kind say."""
    if not parts:
        unknown = Estimate(reason="no motor of this kind reports its angle and its load")
        yield RobotNumber(name, "no_load_speed", "rad/s", unknown)
        return
    all_ = Intervals(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    rows = driven(all_)
    if motor.kind == "geared":
        yield from wheel_numbers(name, rows, all_)
        return
    yield RobotNumber(name, "no_load_speed", "rad/s", _estimate(rows, _speed, _STILL))
    yield RobotNumber(name, "stall_torque", "Nm", _estimate(rows, _stall, _STEADY))


def wheel_numbers(name: str, rows: Floats, all_: Intervals) -> Iterator[RobotNumber]:
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
        read, found = (_estimate(each, statistic, reason) for each in (rows, quiet))
        yield RobotNumber(name, key, unit, _spanned(found, read))
    yield RobotNumber(name, "hold_torque", "Nm", _hold(all_))


def _spanned(found: Estimate, other: Estimate) -> Estimate:
    """Return an estimate whose interval is also that of another one, if both are known."""
    if not (found.known and other.known):
        return found
    return replace(found, low=min(found.low, other.low), high=max(found.high, other.high))


def driven(all_: Intervals) -> Floats:
    """Return rows of duty, load with a minus, and rate of a motor that moves by its duty.

    What stands near its stall is left out by its duty and load, not by its rate: of rates that are
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


def _hold(all_: Intervals) -> Estimate:
    """Return the torque of wheels that were turned at duty 0; a bound where none was."""
    braked = all_.duty == 0
    turned = braked & (all_.rate > _TURNED_RAD_S)
    loads = all_.load[turned]
    if np.count_nonzero(turned) < _LEAST:
        bound = float(np.quantile(all_.load[braked], 0.99)) if braked.any() else np.nan
        return Estimate(low=bound, reason="no wheel was turned against its gears at duty 0")
    most = _estimate(loads[:, None], lambda rows: float(np.quantile(rows, _TURNED_SHARE)), "")
    return _spanned(most, _estimate(loads[:, None], lambda rows: float(np.median(rows)), ""))


def _estimate(rows: Floats, statistic: Callable[[Floats], float], reason: str) -> Estimate:
    """Return a statistic with its interval; unknown where too little was recorded for it."""
    if len(rows) < _LEAST:
        return Estimate(reason=f"{len(rows)} intervals, {_LEAST} are needed: {reason}")
    found = estimate_of(rows, statistic, shortest=3)
    if not np.isfinite(found.value) or found.high - found.low > _MOST_WIDTH * abs(found.value):
        return Estimate(reason=f"between {found.low:.3g} and {found.high:.3g}: {reason}")
    return found


def _frictions(measured: Sequence[MeasuredFile], profile: Profile) -> Iterator[RobotNumber]:
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
        yield RobotNumber("", f"kinetic friction, {part}", "", _kinetic(rows))


def _known_friction(columns: Columns, number: str, signals: SlipSignalNames) -> Floats:
    """Return rows of friction and the torque with which a wheel slipped, where it is known."""
    friction = column(columns, signals.known.format(number))
    torque = np.abs(column(columns, signals.torque.format(number)))
    known = np.isfinite(friction) & np.isfinite(torque)
    rows: Floats = np.column_stack([friction[known], torque[known]])
    return rows


def _kinetic(rows: Sequence[Floats]) -> Estimate:
    if not rows:
        return Estimate(reason="the profile derives no friction of these wheels")
    found = _estimate(np.concatenate(rows), _weighted_median, "no wheel slipped steadily")
    return replace(found, low=found.low * (1 - _STATICS), high=found.high * (1 + _STATICS))


def _weighted_median(rows: Floats) -> float:
    """Return the median of friction, each weighed by its torque: a wheel in the air bears none."""
    order = np.argsort(rows[:, 0])
    weight = np.cumsum(rows[order, 1])
    return float(rows[order[np.searchsorted(weight, weight[-1] / 2)], 0])
