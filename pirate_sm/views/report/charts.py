"""Makes the plots for a robot's profile, with as many points as can be seen.

Nothing here names a robot's parts.
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import degrees, isnan, nan
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from pirate_sm.core.models import Profile
from pirate_sm.core.models import signals as kinds
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.recording.signal_names import current_signals
from pirate_sm.views.report.contents import Chart, Series

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]

# --- values over time ---------------------------------------------------------------------------


MOST_POINTS = 4_000
"""A screen has fewer columns; each board has about this many frames in ten minutes."""


_MOST_KEPT = 4 * MOST_POINTS
"""The most points of a number in memory, however long a run is."""

_EACH = 4
"""The points that represent a bucket: its least, its largest, a gap, its last."""

_FINEST_S = 1 / 64

_AT_ONCE = 1024
"""So many rows of numbers are noted together: one at a time takes many times as long."""


class Curve:
    """A number over time, with few enough points in memory but the same look.

    When there are too many points, they are replaced by representative points of equal intervals.
    The resolution is the same all along the run, and coarser in a longer run.
    """

    def __init__(self) -> None:
        self._times, self._values = array("d"), array("d")
        self._bucket_s = 0.0

    def add(self, times_s: Floats, values: Floats) -> None:
        """Add points; times must not decrease."""
        while len(times_s):
            room = _MOST_KEPT + 1 - len(self._times)
            self._times.frombytes(times_s[:room].tobytes())
            self._values.frombytes(values[:room].tobytes())
            times_s, values = times_s[room:], values[room:]
            if len(self._times) > _MOST_KEPT:
                self._thin()

    def points(self) -> tuple[list[float], list[float]]:
        """Return times and values."""
        if self._bucket_s:
            self._thin()
        return list(self._times), list(self._values)

    def _thin(self) -> None:
        """Reduce the points to at most half of the largest number."""
        times, values = np.array(self._times), np.array(self._values)
        span_s, bucket_s = times[-1] - times[0], self._bucket_s or _FINEST_S
        while span_s / bucket_s > _MOST_KEPT / 2 / _EACH - 2:
            bucket_s *= 2
        self._bucket_s = bucket_s
        begins = np.diff(times // bucket_s, prepend=np.nan) != 0
        kept = _representative(begins.nonzero()[0], values)
        self._times = array("d", times[kept].tobytes())
        self._values = array("d", values[kept].tobytes())


def _representative(begins: Ints, values: Floats) -> Ints:
    """Return the indices of the first point and of those that represent each bucket, in order.

    Args:
        begins: Where the buckets begin, the first one at 0.
        values: The values of all points, NaN if unknown.
    """
    sizes = np.diff(begins, append=len(values))
    bucket = np.repeat(np.arange(len(begins)), sizes)
    least, most = (of.reduceat(values, begins)[bucket] for of in (np.fmin, np.fmax))
    kept = np.zeros(len(values), np.bool_)
    kept[0] = kept[begins + sizes - 1] = True
    for alike in (values == least, values == most, np.isnan(values)):
        found = alike.nonzero()[0]
        kept[found[np.diff(bucket[found], prepend=-1) > 0]] = True  # the first of each bucket
    return kept.nonzero()[0]


class Samples:
    """The values of several numbers, each noted when it was measured or changed."""

    def __init__(self, count: int) -> None:
        self._curves = [Curve() for _ in range(count)]
        self._last: tuple[float, ...] = (nan,) * count
        self._noted = self._last
        self._rows: list[tuple[float, tuple[float, ...], tuple[int, ...]]] = []

    def take(self, at_s: float, numbers: tuple[float, ...], measured: tuple[int, ...] = ()) -> None:
        """Note the numbers that were measured now, and those that changed.

        Args:
            at_s: Time; does not decrease.
            numbers: All numbers, NaN if unknown.
            measured: Indices of those that were measured now, changed or not.
        """
        if numbers is self._last:
            return
        self._last = numbers
        self._rows.append((at_s, numbers, measured))
        if len(self._rows) == _AT_ONCE:
            self._note()

    def _note(self) -> None:
        """Add what was taken to the curves."""
        if not self._rows:
            return
        times, rows, measured = zip(*self._rows, strict=True)
        self._rows = []
        times_s, numbers = np.array(times), np.array((self._noted, *rows), np.float64)
        self._noted = rows[-1]
        unknown = np.isnan(numbers)
        added = (numbers[1:] != numbers[:-1]) & ~(unknown[1:] & unknown[:-1])
        for indices in set(measured):
            own = [row for row, each in enumerate(measured) if each == indices]
            added[np.ix_(own, indices)] = True
        for index in added.any(axis=0).nonzero()[0].tolist():
            own = added[:, index]
            self._curves[index].add(times_s[own], numbers[1:, index][own])

    def series(
        self,
        index: int,
        name: str,
        *,
        scale: float = 1.0,
        stepped: bool = False,
        until_s: float | None = None,
    ) -> Series:
        """Return one of the numbers as a curve.

        Args:
            index: Index of the number.
            name: Name of the curve.
            scale: Factor from SI to the unit of the chart.
            stepped: As in the curve.
            until_s: Time up to which the last value held; None: no longer than its own time.
        """
        self._note()
        times, values = self._curves[index].points()
        values = [value * scale for value in values]
        if until_s is not None and times and times[-1] < until_s:
            times.append(until_s)
            values.append(values[-1])
        return Series(name, *thinned(times, values), stepped=stepped)


def thinned(
    times_s: Sequence[float], values: Sequence[float], most: int = MOST_POINTS
) -> tuple[list[float], list[float]]:
    """Return fewer points that look the same: the representative ones of each bucket.

    The first and the last point remain, and so does every gap.
    """
    size = len(times_s)
    if size <= most:
        return list(times_s), list(values)
    buckets = max(1, most // _EACH)
    begins = size * np.arange(buckets) // buckets
    chosen = _representative(begins, np.array(values, np.float64)).tolist()
    return [times_s[index] for index in chosen], [values[index] for index in chosen]


def value_at(series: Series, at_s: float) -> float:
    """Return the value of the curve at a time, interpolated linearly between points.

    It is NaN before the first point and in a gap. Before a gap and after the last point the value
    holds.
    """
    after = bisect_right(series.times_s, at_s)
    if after == 0:
        return nan
    before = series.values[after - 1]
    if after == len(series.times_s) or series.stepped:
        return before
    t0, t1, other = series.times_s[after - 1], series.times_s[after], series.values[after]
    return before if isnan(other) else before + (other - before) * (at_s - t0) / (t1 - t0)


def over(series: Series, change: Callable[[float, float], float], name: str) -> Series:
    """Return the curve with each value replaced by a function of its time and value."""
    pairs = zip(series.times_s, series.values, strict=True)
    return Series(name, series.times_s, [change(at_s, value) for at_s, value in pairs])


# --- plots --------------------------------------------------------------------------------------


_DEGREES = degrees(1.0)
_BESIDE_S = 0.25
"""A speed is the slope from this long before until this long after."""


@dataclass(frozen=True)
class TravelChart:
    """The distance travelled by the robot, true or estimated.

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
    """All sampled values of a run.

    Attributes:
        bounds: Between which values the normal forces lay, in words.
    """

    profile: Profile
    robot: RobotSpec
    signals: Samples
    setpoints: Samples
    until_s: float
    travel: TravelChart | None
    bounds: str = ""

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
    note = f"By the statics of the chain; unknown where no part is clamped. {it.bounds}".strip()
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
    """Return the slope of a curve around a time; NaN without two points next to it."""

    def rate(at_s: float) -> float:
        times, values = series.times_s, series.values
        low = max(bisect_right(times, at_s - _BESIDE_S) - 1, 0)
        high = min(bisect_right(times, at_s + _BESIDE_S), len(times) - 1)
        if high <= low or times[high] <= times[low]:
            return nan
        return (values[high] - values[low]) / (times[high] - times[low])

    return rate
