"""Makes the plots for a robot's profile; nothing here names a robot's parts."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import degrees, isnan, nan

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model import derived as kinds
from pirate_sm.model.profile import Profile, Slot
from pirate_sm.report.contents import Chart, Series
from pirate_sm.report.sampling import Samples, over, value_at

_DEGREES = degrees(1.0)
_BESIDE_S = 0.25
"""A speed is the slope from this long before until this long after."""


@dataclass(frozen=True)
class Travel:
    """The distance travelled by the robot, true or reckoned.

    Attributes:
        true: Whether it is known from a simulator.
        distance: Distance of the robot's middle along the pipe, m.
        wheels: Position of each wheel along the pipe, m.
    """

    true: bool
    distance: Series
    wheels: tuple[Series, ...]


@dataclass(frozen=True)
class Measured:
    """All sampled values of a run."""

    profile: Profile
    robot: RobotSpec
    signals: Samples
    setpoints: Samples
    until_s: float
    travel: Travel | None

    def signal(self, name: str, scale: float = 1.0) -> Series:
        """Return a signal by its name."""
        index = self.robot.vocabulary.numbers.index(name)
        return self.signals.series(index, name, scale=scale)

    def rim(self, number: int, scale: float = 1.0) -> Series:
        """Return the forward speed of a wheel's rim, m/s."""
        wheel = self.robot.wheels[number]
        label = self.profile.body.wheels[number].name
        scale *= wheel.metres_per_rad
        return self.signals.series(wheel.speed, label, scale=scale)


def charts(measured: Measured) -> tuple[Chart, ...]:
    """Return the plots that have a curve with a point in it."""
    found = (make(measured) for make in _CHARTS)
    return tuple(chart for each in found if (chart := _filled(each)) is not None)


def _filled(chart: Chart) -> Chart | None:
    series = tuple(each for each in chart.series if not all(map(isnan, each.values)))
    return Chart(chart.title, chart.unit, chart.digits, series, chart.note) if series else None


def _angles(it: Measured) -> Chart:
    body = it.profile.body
    names = [joint.name for joint in body.joints] + [link.roll for link in body.links if link.roll]
    series = tuple(it.signal(name, _DEGREES) for name in names)
    return Chart("Joint angles", "°", 2, series)


def _joint_torques(it: Measured) -> Chart:
    names = [joint.torque for joint in it.profile.body.joints if joint.torque]
    return Chart("Joint torques", "Nm", 3, tuple(it.signal(name) for name in names))


def _wheel_torques(it: Measured) -> Chart:
    known = {joint.torque for joint in it.profile.body.joints}
    names = [name for name in _derived(it.profile, kinds.TorqueOf) if name not in known]
    note = "From the motors' currents; the sign is that of the setpoint."
    return Chart("Motor torques", "Nm", 3, tuple(it.signal(name) for name in names), note)


def _wheel_currents(it: Measured) -> Chart:
    series = _currents(it, lambda slot: slot.wheel is not None)
    return Chart("Wheel motor currents", "mA", 0, tuple(series))


def _other_currents(it: Measured) -> Chart:
    series = _currents(it, lambda slot: slot.wheel is None)
    return Chart("Joint motor currents", "mA", 0, tuple(series))


def _currents(it: Measured, wanted: Callable[[Slot], bool]) -> Iterator[Series]:
    slots = {slot.name: slot for slot in it.profile.slots}
    for board in it.profile.boards:
        for channel in board.channels:
            if channel.senses != "current" or channel.signal is None or channel.slot is None:
                continue
            if wanted(slots[channel.slot]):
                yield it.signal(channel.signal, 1e3)


def _rim_speeds(it: Measured) -> Chart:
    series = [it.rim(number, 1e3) for number in range(len(it.robot.wheels))]
    return Chart("Wheel speeds at the rim", "mm/s", 1, tuple(series), "Positive is forward.")


def _slip(it: Measured) -> Chart:
    title = "Slip"
    rims = [it.rim(number) for number in range(len(it.robot.wheels))]
    if it.travel is not None and it.travel.true:
        series = [
            over(rim, _less(_rate(place), 1e3), rim.name)
            for rim, place in zip(rims, it.travel.wheels, strict=True)
        ]
        note = "How much faster the rim goes forward than its wheel really gets on along the pipe."
        return Chart(title, "mm/s", 1, tuple(series), note)
    if it.robot.speed < 0:
        return Chart(title, "mm/s", 1, ())
    mean = it.signals.series(it.robot.speed, "")
    series = [over(rim, _less(lambda at_s: value_at(mean, at_s), 1e3), rim.name) for rim in rims]
    note = "How much faster the rim goes forward than the driven wheels do on average."
    return Chart(title, "mm/s", 1, tuple(series), note)


def _normal_forces(it: Measured) -> Chart:
    note = "By the statics of the chain; unknown where no part is clamped."
    series = _signals(it, kinds.NormalForceOf, 1.0)
    return Chart("Normal forces", "N", 1, tuple(series), note)


def _frictions(it: Measured) -> Chart:
    note = "Known where a wheel slips steadily and somebody outside measures the speed."
    return Chart("Friction", "", 2, tuple(_signals(it, kinds.FrictionOf, 1.0)), note)


def _distance(it: Measured) -> Chart:
    series = []
    if it.robot.odometry >= 0:
        name = it.robot.vocabulary.numbers[it.robot.odometry]
        series.append(it.signals.series(it.robot.odometry, name))
    if it.travel is not None and it.travel.true:
        series.append(it.travel.distance)
    return Chart("Distance", "m", 4, tuple(series))


def _speeds(it: Measured) -> Chart:
    series = []
    if it.robot.speed >= 0:
        name = it.robot.vocabulary.numbers[it.robot.speed]
        series.append(it.signals.series(it.robot.speed, name, scale=1e3))
    if it.travel is not None and it.travel.true:
        rate, distance = _rate(it.travel.distance), it.travel.distance
        series.append(over(distance, lambda at_s, _: rate(at_s) * 1e3, distance.name))
    return Chart("Speed", "mm/s", 1, tuple(series))


def _diameters(it: Measured) -> Chart:
    note = "As a part sees it, whether or not it is clamped."
    series = _signals(it, kinds.DiameterOf, 1e3)
    return Chart("Inner diameter", "mm", 1, tuple(series), note)


def _attitude(it: Measured) -> Chart:
    series = [*_signals(it, kinds.RollOf, _DEGREES), *_signals(it, kinds.PitchOf, _DEGREES)]
    return Chart("Roll and pitch", "°", 2, tuple(series))


def _duties(it: Measured) -> Chart:
    return Chart("Setpoints: duty cycles", "%", 1, tuple(_setpoints(it, "duty", 100.0)))


def _angle_setpoints(it: Measured) -> Chart:
    return Chart("Setpoints: angles", "°", 2, tuple(_setpoints(it, "angle", _DEGREES)))


_CHARTS: tuple[Callable[[Measured], Chart], ...] = (
    *(
        _angles,
        _joint_torques,
        _other_currents,
        _wheel_currents,
        _rim_speeds,
        _slip,
        _normal_forces,
    ),
    *(
        _frictions,
        _distance,
        _speeds,
        _wheel_torques,
        _diameters,
        _attitude,
        _duties,
        _angle_setpoints,
    ),
)


def _derived(profile: Profile, kind: type) -> Iterator[str]:
    return (name for name, each in profile.derived.items() if isinstance(each, kind))


def _signals(it: Measured, kind: type, scale: float) -> Iterable[Series]:
    return (it.signal(name, scale) for name in _derived(it.profile, kind))


def _setpoints(it: Measured, unit: str, scale: float) -> Iterator[Series]:
    """Yield the setpoints of slots that ever had another value than zero."""
    for index, slot in enumerate(it.robot.slots):
        if slot.unit != unit:
            continue
        series = it.setpoints.series(
            index, slot.name, scale=scale, stepped=True, until_s=it.until_s
        )
        if any(series.values):
            yield series


def _less(taken: Callable[[float], float], scale: float) -> Callable[[float, float], float]:
    return lambda at_s, value: (value - taken(at_s)) * scale


def _rate(series: Series) -> Callable[[float], float]:
    """Return the slope of a curve around a time; NaN without two points beside it."""

    def rate(at_s: float) -> float:
        times, values = series.times_s, series.values
        low = max(bisect_right(times, at_s - _BESIDE_S) - 1, 0)
        high = min(bisect_right(times, at_s + _BESIDE_S), len(times) - 1)
        if high <= low or times[high] <= times[low]:
            return nan
        return (values[high] - values[low]) / (times[high] - times[low])

    return rate
