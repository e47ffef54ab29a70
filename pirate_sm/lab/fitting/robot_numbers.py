"""Estimates the numbers of a robot that nobody measured, from a recording of it.

A motor turns with ω0 (u − τ / τ_stall): with duty u, load τ, speed without load ω0. Of a joint
behind a spring that is the motor's side, γ + τ / K. Two readings give an equation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pirate_sm.core.models import Motor, Profile
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
from pirate_sm.lab.fitting.motor_intervals import Intervals, duties, intervals_of, load_signals
from pirate_sm.lab.fitting.traction_again import signals_with
from pirate_sm.running.recording.tables import TIME
from pirate_sm.simulation.arrays import Floats

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
"""A torque of rolling that is less than so many standard deviations may be noise alone."""

_ROLLS = 0.5
"""A wheel that turns at less than this share of its speed without load does more than roll
[assumed]."""

_PRESSED = 0.3
"""Error of the sum of normal forces by statics, of a robot that has driven: twice the 15 % by which
simulators may differ [assumed]. Before it has driven it may be a factor (docs/decisions/0123)."""

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
        motor: Kind of motor; empty for all that is not a number of a motor.
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
    believed = profile.simulation.tyre.rolling_resistance
    more = resistance.value - believed if resistance.known else 0.0
    frictions = _frictions(shown, profile, more, stream)
    return [*found, *frictions, RobotNumber("", ROLLING, "", resistance)]


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
    """Return the share of its motor's torque that a standing joint nearly always bears.

    If `share` of a clamp in the profile is larger, the clamp may never be confirmed: in the
    thesis joints bore 0.16 to 1.92 Nm where their motors should give 0.7 (section 7-1-1).
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
    measured: Sequence[MeasuredFile], profile: Profile, resisted: float, stream: int
) -> Iterator[RobotNumber]:
    """Yield kinetic friction of each part, where the profile derives it for its wheels.

    Args:
        measured: The recordings.
        profile: Of the robot.
        resisted: By how much more its tyres resist rolling than the engine believed, which took
            that much of what they resist for friction.
        stream: Of the draws.
    """
    names = [wheel.name for wheel in profile.body.wheels]
    signals = SlipSignalNames(radius_m=profile.body.wheel_radius)
    for part in profile.body.parts:
        numbers = [
            str(names.index(wheel.name) + 1) for wheel in profile.body.wheels if wheel.part == part
        ]
        rows = [
            _known_friction(each.columns, number, signals) - [resisted, 0.0]
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
    """Return rows of rolling resistance while all wheels drive, as a share of the normal forces.

    At a constant speed the forces along the pipe add up to zero: the motors bear the resistance and
    the weight, and the weight changes its sign on the way back. Currents have no sign, so a torque
    counts as negative where its wheel surely turns faster than without load. A row has the
    resistance by all torques, by those that are more than noise, and the direction of driving.
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
        duty = duties(measured.setpoints, slot.name, columns[TIME])
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
    """Return the mean of both directions; unknown if it may be the noise of currents."""
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
