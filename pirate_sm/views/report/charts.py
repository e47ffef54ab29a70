"""Makes the plots for a robot's profile; nothing here names a robot's parts."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from math import degrees, isnan, nan

from pirate_sm.core.profile import Profile
from pirate_sm.core.profile import derived as kinds
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.recording.columns import current_signals
from pirate_sm.views.report.contents import Chart, Series
from pirate_sm.views.report.sampling import Samples, over, value_at

_DEGREES = degrees(1.0)
_BESIDE_S = 0.25
"""A speed is the slope from this long before until this long after."""


@dataclass(frozen=True)
class TravelChart:
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
    travel: TravelChart | None

    def named(self, names: Iterable[str], scale: float = 1.0) -> tuple[Series, ...]:
        """Return signals by their names, without those that no board of the robot measures."""
        known = self.robot.vocabulary.numbers
        found = ((known.index(name), name) for name in names if name in known)
        return tuple(self.signals.series(index, name, scale=scale) for index, name in found)

    def derived(self, kind: type, scale: float = 1.0) -> tuple[Series, ...]:
        """Return the derived signals of a kind."""
        derived = self.profile.derived.items()
        return self.named((name for name, each in derived if isinstance(each, kind)), scale)

    def rim(self, number: int, scale: float = 1.0) -> Series:
        """Return the forward speed of a wheel's rim, m/s."""
        wheel = self.robot.wheels[number]
        label = self.profile.body.wheels[number].name
        scale *= wheel.metres_per_rad
        return self.signals.series(wheel.speed, label, scale=scale)


def charts(measured: Measured) -> tuple[Chart, ...]:
    """Return the plots that have a curve with a point in it."""
    found = (*_of_joints(measured), *_of_wheels(measured), *_of_way(measured), *_others(measured))
    return tuple(chart for each in found if (chart := _filled(each)) is not None)


def _filled(chart: Chart) -> Chart | None:
    series = tuple(each for each in chart.series if not all(map(isnan, each.values)))
    return replace(chart, series=series) if series else None


def _of_joints(it: Measured) -> Iterator[Chart]:
    joints, rolls = it.profile.body.joints, [link.roll for link in it.profile.body.links]
    names = [joint.name for joint in joints] + [roll for roll in rolls if roll]
    yield Chart("Joint angles", "°", 2, it.named(names, _DEGREES))
    torques = [joint.torque for joint in joints if joint.torque]
    yield Chart("Joint torques", "Nm", 3, it.named(torques))
    yield Chart(
        "Joint motor currents", "mA", 0, it.named(current_signals(it.profile, of_wheels=False), 1e3)
    )


def _of_wheels(it: Measured) -> Iterator[Chart]:
    yield Chart(
        "Wheel motor currents", "mA", 0, it.named(current_signals(it.profile, of_wheels=True), 1e3)
    )
    rims = tuple(it.rim(number, 1e3) for number in range(len(it.robot.wheels)))
    yield Chart("Wheel speeds at the rim", "mm/s", 1, rims, "Positive is forward.")
    yield _slip(it)
    note = "By the statics of the chain; unknown where no part is clamped."
    yield Chart("Normal forces", "N", 1, it.derived(kinds.NormalForceOf), note)
    note = "Known if a wheel slips steadily and an outside sensor measures the speed."
    yield Chart("Friction", "", 2, it.derived(kinds.FrictionOf), note)


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


def _of_way(it: Measured) -> Iterator[Chart]:
    names, travel = it.robot.vocabulary.numbers, it.travel
    distances = [*it.named(names[i] for i in [it.robot.odometry] if i >= 0)]
    speeds = [*it.named((names[i] for i in [it.robot.speed] if i >= 0), 1e3)]
    if travel is not None and travel.true:
        rate, distance = _rate(travel.distance), travel.distance
        distances.append(distance)
        speeds.append(over(distance, lambda at_s, _: rate(at_s) * 1e3, distance.name))
    yield Chart("Distance", "m", 4, tuple(distances))
    yield Chart("Speed", "mm/s", 1, tuple(speeds))


def _others(it: Measured) -> Iterator[Chart]:
    known = {joint.torque for joint in it.profile.body.joints}
    torques = [each for each in it.derived(kinds.TorqueOf) if each.name not in known]
    note = "From the motors' currents; the sign is that of the setpoint."
    yield Chart("Motor torques", "Nm", 3, tuple(torques), note)
    note = "As a part sees it, whether or not it is clamped."
    yield Chart("Inner diameter", "mm", 1, it.derived(kinds.DiameterOf, 1e3), note)
    angles = it.derived(kinds.RollOf, _DEGREES) + it.derived(kinds.PitchOf, _DEGREES)
    yield Chart("Roll and pitch", "°", 2, angles)
    yield Chart("Setpoints: duty cycles", "%", 1, tuple(_setpoints(it, "duty", 100.0)))
    yield Chart("Setpoints: angles", "°", 2, tuple(_setpoints(it, "angle", _DEGREES)))


def _setpoints(it: Measured, unit: str, scale: float) -> Iterator[Series]:
    """Yield the setpoints of slots that ever had another value than zero."""
    for index, slot in enumerate(it.robot.slots):
        if slot.unit != unit:
            continue
        series = it.setpoints.series(
            index, slot.name, scale=scale, stepped=True, until_s=it.until_s
        )
        if any(value and not isnan(value) for value in series.values):
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
