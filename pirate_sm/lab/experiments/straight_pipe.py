"""Repeats an experiment up and down a straight pipe: table 6-1 and figures 6-1 to 6-8."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import nan
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import numpy as np

from pirate_sm.api import Run, run
from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import height_m, span_m
from pirate_sm.core.models import Profile, Wheel
from pirate_sm.core.models import signals as kinds
from pirate_sm.lab.experiments.clamp_readings import explain_clamp
from pirate_sm.lab.experiments.setups import (
    ExperimentResult,
    PostProcessing,
    StraightPipeSetup,
    Watch,
)
from pirate_sm.lab.experiments.slip_histogram import slip_histogram
from pirate_sm.lab.fitting.measurements import column
from pirate_sm.lab.fitting.slip_curve import fit_slip_curve, slip_plot
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.simulation.arrays import Floats
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries

# --- slip and forces -----------------------------------------------------------------------------


@dataclass
class SlipSignals:
    """The signals of a run at even steps of time, smoothed.

    Attributes:
        run: The run, with true places of its wheels.
        processing: How its signals are made comparable.
        seen: When a camera saw the robot, and where along the pipe; None: where it truly was.
    """

    run: Run
    processing: PostProcessing
    seen: tuple[Floats, Floats] | None = None

    @cached_property
    def _columns(self) -> dict[str, Floats]:
        return {name: np.array(values) for name, values in self.run.signals.items()}

    @cached_property
    def _profile(self) -> Profile:
        return self.run.loaded.loaded_robot.profile

    @cached_property
    def times_s(self) -> Floats:
        """Even steps of time."""
        times: Floats = np.arange(0.0, self._columns["time_s"][-1], self.processing.step)
        return times

    @cached_property
    def speed_m_s(self) -> Floats:
        """Of the robot along the pipe, as the camera has seen it, or by the truth.

        Raises:
            UsageError: Nobody knew where the robot was.
        """
        if self.seen is not None:
            return self._rate(*self.seen)
        poses = self.run.poses()
        if poses is None:
            raise UsageError("the backend does not know where the robot is: experiments need it")
        along = np.array([sum(x for x, _ in points) / len(points) for points in poses.points])
        return self._rate(np.array(poses.times_s), along)

    def rim_m_s(self, wheel: Wheel) -> Floats:
        """Return the wheel's rim speed, from differences of its angle (eq. 5-1)."""
        angle = column(self._columns, wheel.angle)
        return self._profile.body.wheel_radius * wheel.direction * self._rate(*self._first(angle))

    def slip_m_s(self, wheel: Wheel) -> Floats:
        """Return the slip speed r d ω − v."""
        return self.rim_m_s(wheel) - self.speed_m_s

    def ratio(self, wheel: Wheel) -> Floats:
        """Return the slip ratio (eq. 3-1); NaN where the robot is all but still."""
        moving = np.abs(self.speed_m_s) >= self.processing.still_below
        ratio: Floats = -self.slip_m_s(wheel) / np.where(moving, self.speed_m_s, np.nan)
        return ratio

    def driving_ratio(self, wheel: Wheel) -> Floats:
        """Return the slip ratios while the robot drives."""
        return self.ratio(wheel)[np.abs(self.speed_m_s) >= self.processing.driving_above]

    def joint_torque(self, joint: str) -> Floats:
        """Return the torque of a joint, smoothed."""
        name = next(each.torque for each in self._profile.body.joints if each.name == joint)
        return self._smooth(*self._first(column(self._columns, name or joint)))

    def normal_n(self, wheel: Wheel) -> Floats:
        """Return the normal force as the thesis takes it: from the apex of the part (eq. 3-3)."""
        body = self._profile.body
        apex = body.parts[wheel.part].apex
        leg_m = min(body.legs_m(wheel.part))
        joint = next(each for each in body.joints if each.name == apex)
        angle = self._smooth(*self._first(column(self._columns, apex)))
        lever = np.array([span_m(leg_m, height_m(leg_m, each)) for each in angle])
        share = 2.0 if joint.wheel == wheel.name else 1.0
        normal: Floats = (
            share * np.abs(self.joint_torque(apex)) / np.where(lever > 0, lever, np.nan)
        )
        return normal

    def friction_n(self, wheel: Wheel) -> Floats:
        """Return the friction force from the motor's current (eq. 5-3)."""
        slots = {slot.wheel: slot.name for slot in self._profile.slots if slot.wheel}
        name = self._profile.derived_by(kinds.TorqueOf, slot=slots[wheel.name])
        torque = self._smooth(*self._first(column(self._columns, name)))
        return np.abs(torque) / self._profile.body.wheel_radius

    def friction(self, wheel: Wheel) -> Floats:
        """Return the friction coefficient in use; NaN where nothing presses."""
        return self._used(wheel, self.normal_n(wheel))

    def statics_friction(self, wheel: Wheel) -> Floats:
        """Return the same with the normal force by the statics of the whole chain."""
        name = self._profile.derived_by(kinds.NormalForceOf, normal_force_of=wheel.name)
        return self._used(wheel, self._smooth(*self._first(column(self._columns, name))))

    def _used(self, wheel: Wheel, normal: Floats) -> Floats:
        used: Floats = self.friction_n(wheel) / np.where(normal > 0.5, normal, np.nan)
        return used

    @cached_property
    def stretches(self) -> list[tuple[Floats, Floats]]:
        """The stretches of driving: when each was commanded, and when the robot drove in it."""
        commands = self.run.commands
        given = zip(commands["time_s"], commands["status"], strict=True)
        bounds = [*(at for at, status in given if status == "accepted"), self.times_s[-1]]
        drives = np.abs(self.speed_m_s) >= self.processing.driving_above
        spans = [(self.times_s >= a) & (self.times_s < b) for a, b in pairwise(bounds)]
        return [(span, span & drives) for span in spans if (span & drives).any()]

    def drive_values(self, wheel: Wheel) -> dict[str, float]:
        """Return what section 6-2 says of a wheel that starts, drives, and is blocked.

        How much friction grows beyond that at rest when the wheel is driven, N; its peak at a
        start over that in driving; how the clamp force grew from the first stretch to the last;
        and where the robot was held up, the rim speed over that in driving.
        """
        force, normal, rim = self.friction_n(wheel), self.normal_n(wheel), self.rim_m_s(wheel)
        found: dict[str, float] = {}
        if not self.stretches or not rim.any():
            return found
        (first, at_first), (_, at_last) = self.stretches[0], self.stretches[-1]
        still = np.abs(self.speed_m_s) < self.processing.still_below
        rests = still & ~np.any([span for span, _ in self.stretches], axis=0)
        rests &= np.maximum.accumulate(first)
        driven = np.any([drives for _, drives in self.stretches], axis=0)
        if rests.any():
            found["rise"] = float(np.median(force[driven]) - np.median(force[rests]))
        found["growth"] = float(np.median(normal[at_last])) / _positive(np.median(normal[at_first]))
        peaks = []
        for span, drives in self.stretches:
            begun = np.maximum.accumulate(drives)
            peaks.append(float(np.max(force[span & ~begun])) / _positive(np.median(force[drives])))
            ended = np.maximum.accumulate(drives[::-1])[::-1]
            held_up = span & begun & ended & still
            if held_up.any():
                way = "forward" if np.median(self.speed_m_s[drives]) > 0 else "backward"
                found[f"blocked_{way}"] = float(np.median(rim[held_up])) / float(
                    np.median(rim[drives]) or nan
                )
        found["start_peak"] = float(np.median(peaks))
        return found

    def _first(self, values: Floats) -> tuple[Floats, Floats]:
        """Return times and values without repetitions and without what is unknown."""
        known = np.isfinite(values)
        times, values = self._columns["time_s"][known], values[known]
        fresh = np.concatenate([[True], np.diff(values) != 0])
        return times[fresh], values[fresh]

    def _smooth(self, times: Floats, values: Floats) -> Floats:
        """Return the values at even steps, in a moving average that is centred."""
        if not len(times):
            return np.full(len(self.times_s), np.nan)
        even = np.interp(self.times_s, times, values)
        count = max(round(self.processing.window / self.processing.step), 1)
        padded = np.pad(even, (count // 2, count - 1 - count // 2), mode="edge")
        total = np.cumsum(np.concatenate([[0.0], padded]))
        smoothed: Floats = (total[count:] - total[:-count]) / count
        return smoothed

    def _rate(self, times: Floats, values: Floats) -> Floats:
        rate: Floats = np.gradient(self._smooth(times, values), self.processing.step)
        return rate


# --- the experiment ------------------------------------------------------------------------------


def seen_run(
    mission: str, camera: str, defects: Sequence[str]
) -> tuple[Run, tuple[Floats, Floats]]:
    """Return a run with the camera as detector, and when and where it saw the robot.

    Args:
        mission: Name of the mission.
        camera: Name of a synthetic camera.
        defects: That the robot has.

    Returns:
        The run; times in s and the mean position of the wheels that were seen, m along the pipe.

    Raises:
        LoadError: The mission or the camera cannot be loaded.
        UsageError: An extra is not installed.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "seen.mcap"
        made = run(mission, defects=defects, detector=f"vision:{camera}", record=path)
        body = made.loaded.loaded_robot.profile.body
        names = [f"{wheel.name}_m" for wheel in body.wheels]
        seen: dict[float, float] = {}
        for shown in read_recording(path).shown("/vision"):
            places = [shown.content[name] for name in names if name in shown.content]
            if len(places) == len(names):
                seen[round(shown.at_s - shown.content["age_s"], 6)] = fmean(places)
    return made, (np.array(list(seen)), np.array(list(seen.values())))


_DRAWN = 5
"""Every fifth step is drawn."""


def repeat_straight_pipe(
    profile: Profile,
    setup: StraightPipeSetup,
    parts: tuple[str, ...],
    *,
    watch: Watch = lambda share: None,
) -> ExperimentResult:
    """Return values and figures of the parts of the experiment.

    Args:
        profile: Of the robot.
        setup: The experiment.
        parts: Which of its parts.
        watch: Receives the share that is done.

    Raises:
        LoadError: A mission cannot be loaded.
        UsageError: The simulator is not installed.
    """
    result = ExperimentResult()
    wheels = [wheel for wheel in profile.body.wheels if wheel.name in setup.wheels]
    further = [part for part in parts if part in setup.again]
    seen = [part for part in parts if part in setup.seen]
    share = 1 / (len(parts) + len(further) + len(seen))
    for number, part in enumerate(parts):
        watch(number * share)
        made = run(setup.missions[part], defects=setup.defects)
        signals = SlipSignals(made, setup.processing)
        _take_in(result, part, part, signals, wheels)
        result.figures += [
            slip_histogram(setup.rows, part, wheel.name, signals.driving_ratio(wheel))
            for wheel in wheels
        ]
        if part == setup.shown:
            result.figures += _figures(signals, wheels, profile)
            if setup.clamp is not None and made.loaded.pipe is not None:
                explain_clamp(profile, setup.clamp, made.loaded.pipe.diameter, result)
    for number, part in enumerate(further, start=len(parts)):
        watch(number * share)
        backend, pipe = setup.again[part].backend, setup.again[part].pipe
        title = f"{part} on {backend}"
        if not result.can_run(title, backend):
            continue
        made = run(setup.missions[part], backend, pipe=pipe, defects=setup.defects)
        signals = SlipSignals(made, setup.processing)
        _take_in(result, f"{part}.{backend}", title, signals, wheels)
    for number, part in enumerate(seen, start=len(parts) + len(further)):
        watch(number * share)
        title = f"{part} by the camera {setup.seen[part]}"
        if not result.can_run(title, "vision"):
            continue
        made, places = seen_run(setup.missions[part], setup.seen[part], setup.defects)
        signals = SlipSignals(made, setup.processing, places)
        _take_in(result, f"{part}.seen", title, signals, wheels)
    return result


def _take_in(
    result: ExperimentResult, name: str, title: str, signals: SlipSignals, wheels: list[Wheel]
) -> None:
    """Add the values of a run by this name, and a note with this title."""
    made = signals.run
    result.notes.append(f"{title}: {made.outcome} after {made.duration_s:.1f} s, {made.message}")
    for wheel in wheels:
        values = _wheel_values(signals, wheel)
        result.values |= {f"{name}.{wheel.name}.{key}": value for key, value in values.items()}
    for joint in made.loaded.loaded_robot.profile.body.joints:
        torque = np.abs(signals.joint_torque(joint.name))
        result.values[f"{name}.{joint.name}.torque_median"] = float(np.median(torque))
        result.values[f"{name}.{joint.name}.torque_mean"] = float(np.mean(torque))
    friction = {wheel.name: result.values[f"{name}.{wheel.name}.most_friction"] for wheel in wheels}
    for this, most in friction.items():
        least = min(friction[other] for other in friction if other != this)
        result.values[f"{name}.{this}.friction_share"] = most / least if least > 0 else nan


def _wheel_values(signals: SlipSignals, wheel: Wheel) -> dict[str, float]:
    """Return the statistics of table 6-1 and what section 6-2 says of friction and blocks."""
    ratio = signals.ratio(wheel)
    ratio = ratio[np.isfinite(ratio)]
    driven = signals.driving_ratio(wheel)
    within = ratio[np.abs(ratio) <= signals.processing.most_ratio]
    return {
        "driving_median": _or_nan(np.median, driven),
        "driving_mean": _or_nan(np.mean, driven),
        "driving_std": _or_nan(np.std, driven),
        "within_mean": _or_nan(np.mean, within),
        "within_std": _or_nan(np.std, within),
        "least": _or_nan(np.min, ratio),
        "most_friction": _or_nan(np.nanmax, signals.friction(wheel)),
        "statics_friction": _or_nan(np.nanmax, signals.statics_friction(wheel)),
    } | signals.drive_values(wheel)


def _positive(value: np.floating) -> float:
    return float(value) if value > 0 else nan


def _or_nan(statistic: object, values: Floats) -> float:
    return float(statistic(values)) if len(values) else float("nan")  # type: ignore[operator]


def _figures(signals: SlipSignals, wheels: list[Wheel], profile: Profile) -> list[Plot]:
    times = signals.times_s
    joints = [joint.name for joint in profile.body.joints]
    ratios = [np.clip(signals.ratio(wheel), -2, 2) for wheel in wheels]
    names = [wheel.name for wheel in wheels]
    normals = [signals.normal_n(wheel) for wheel in wheels]
    forces = [signals.friction_n(wheel) for wheel in wheels]
    used = [signals.friction(wheel) for wheel in wheels]
    rims = [signals.rim_m_s(wheel) for wheel in wheels]
    torques = [signals.joint_torque(each) for each in joints]
    slips = [np.abs(signals.slip_m_s(wheel)) for wheel in wheels]
    marker = ["marker", *names]
    return [
        _over_time("Fig. 6-1: joint torques", "Nm", times, joints, torques),
        _over_time("Fig. 6-2: speeds", "m/s", times, marker, [signals.speed_m_s, *rims]),
        _over_time("Fig. 6-3: slip ratio", "slip ratio", times, names, ratios),
        _over_time("Fig. 6-4: normal forces", "N", times, names, normals),
        _over_time("Fig. 6-4: friction forces", "N", times, names, forces),
        _over_time("Fig. 6-5: friction in use", "F / N", times, names, used),
        _cloud("Fig. 6-6: friction over slip ratio", "slip ratio", names, ratios, used),
        _cloud("Fig. 6-7: friction over slip speed", "|v - d w r|, m/s", names, slips, used),
        *_fits(signals, wheels),
    ]


def _fits(signals: SlipSignals, wheels: list[Wheel]) -> list[Plot]:
    """Return the fits of fig. 6-8, one for each wheel."""
    every = signals.processing.every
    curves = (
        (wheel, fit_slip_curve(signals.slip_m_s(wheel)[::every], signals.friction(wheel)[::every]))
        for wheel in wheels
    )
    return [slip_plot(curve, f"Fig. 6-8: {wheel.name}, both fits") for wheel, curve in curves]


def _over_time(
    title: str, unit: str, times: Floats, names: list[str], values: list[Floats]
) -> Plot:
    series = tuple(
        PlotSeries(name, times[::_DRAWN].tolist(), each[::_DRAWN].tolist(), colour=number)
        for number, (name, each) in enumerate(zip(names, values, strict=True))
    )
    return Plot(title, "time, s", unit, series)


def _cloud(title: str, x_label: str, names: list[str], x: list[Floats], y: list[Floats]) -> Plot:
    series = tuple(
        PlotSeries(name, a[::_DRAWN].tolist(), b[::_DRAWN].tolist(), "dots", colour=number)
        for number, (name, a, b) in enumerate(zip(names, x, y, strict=True))
    )
    return Plot(title, x_label, "friction in use F / N", series)
