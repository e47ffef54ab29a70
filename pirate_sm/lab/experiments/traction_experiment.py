"""Repeats a traction experiment on the reduced physics: its values and figures 6-10 to 6-12."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from statistics import median

import numpy as np

from pirate_sm.api import Run, run
from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Profile
from pirate_sm.core.spelling import one_of
from pirate_sm.lab.experiments.reduced_traction import TractionRun, run_traction
from pirate_sm.lab.experiments.setups import (
    ExperimentResult,
    NoiseLevel,
    OwnLoops,
    Sensitivity,
    TractionSetup,
    Watch,
)
from pirate_sm.lab.experiments.wall_contact import contact_values
from pirate_sm.lab.fitting.measurements import column
from pirate_sm.lab.fitting.slip_curve import SlipCurve, fit_slip_curve, slip_plot
from pirate_sm.simulation.arrays import Floats
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries

# --- the engine's own loops ----------------------------------------------------------------------


def repeat_with_loops(
    loops: OwnLoops, parts: tuple[str, ...], *, seeds: int = 1, watch: Watch = lambda share: None
) -> ExperimentResult:
    """Return how far the odometry of each variant was off, and where it drove.

    The values of a part are `error`, between the way of the robot and what its wheels have rolled,
    a mean of the wheels; `way`, between its outermost places; `place`, where it ended; all since
    the first drive began, and medians of the seeds.

    Args:
        loops: The missions.
        parts: Which variants.
        seeds: How many runs of each.
        watch: Receives the share that is done.

    Raises:
        LoadError: A mission cannot be loaded.
        UsageError: The backend does not know where the robot is, or a mission does not drive.
    """
    result = ExperimentResult()
    if not result.can_run(f"{', '.join(parts)} on {loops.backend}", loops.backend):
        return result
    drawn = []
    wanted = [part for part in parts if part in loops.missions]
    for number, part in enumerate(wanted):
        watch(number / len(wanted))
        runs = [run(loops.missions[part], loops.backend, seed=seed) for seed in range(seeds)]
        first = runs[0]
        result.notes.append(
            f"{part} on {loops.backend}: {first.outcome} after {first.duration_s:.1f} s,"
            f" {first.message}"
        )
        driven = [_Driven(each, loops.since) for each in runs]
        name = f"{part}.{loops.backend}"
        result.values[f"{name}.error"] = median(each.error_m for each in driven)
        result.values[f"{name}.way"] = median(float(np.ptp(each.place_m)) for each in driven)
        result.values[f"{name}.place"] = median(float(each.place_m[-1]) for each in driven)
        times, places = driven[0].times_s.tolist(), driven[0].place_m.tolist()
        drawn.append(PlotSeries(part, times, places, colour=number))
    title = f"Fig. 6-10 by the engine's own loops, on {loops.backend}: place in the pipe"
    result.figures.append(Plot(title, "time, s", "x, m", tuple(drawn)))
    return result


class _Driven:
    """A run since its first drive: where the robot was, and how far its odometry is off.

    Attributes:
        times_s: Times.
        place_m: Of the robot along the pipe, 0 at the beginning.
        error_m: What the wheels have rolled beyond the way of the robot at the end, their mean.
    """

    def __init__(self, made: Run, since: str) -> None:
        commands = zip(made.commands["name"], made.commands["time_s"], strict=True)
        begins_s = next((time for name, time in commands if name == since), None)
        poses = made.poses()
        if begins_s is None or poses is None:
            raise UsageError(
                f"{made.header.mission}: experiments need a backend that knows where the robot is,"
                f" and the command {since}"
            )
        times = np.array(poses.times_s)
        places = np.array([sum(x for x, _ in points) / len(points) for points in poses.points])
        driven = times >= begins_s
        self.times_s: Floats = times[driven]
        self.place_m: Floats = places[driven] - places[driven][0]
        self.error_m = abs(float(self.place_m[-1]) - _rolled_m(made, begins_s))


def _rolled_m(made: Run, begins_s: float) -> float:
    """Return how far the wheels have rolled since, positive forward, their mean."""
    body = made.loaded.loaded_robot.profile.body
    columns = {name: np.array(values) for name, values in made.signals.items()}
    times = columns["time_s"]
    rolled = []
    for wheel in body.wheels:
        angle = column(columns, wheel.angle)
        known = np.isfinite(angle)
        first = float(np.interp(begins_s, times[known], angle[known]))
        turned = float(angle[known][-1]) - first
        rolled.append(body.wheel_radius * wheel.direction * turned)
    return sum(rolled) / len(rolled)


# --- the experiment ------------------------------------------------------------------------------


_STICKING = "sticking"
"""Level of values where friction sticks, with the noise of the last level that is run."""

_DRAWN = 20
"""Every twentieth tick is drawn."""


def repeat_traction(
    profile: Profile,
    setup: TractionSetup,
    parts: tuple[str, ...],
    *,
    noise: str | None = None,
    seeds: int = 1,
    watch: Watch = lambda share: None,
) -> ExperimentResult:
    """Return values and figures of the variants.

    Args:
        profile: Of the robot.
        setup: The experiment.
        parts: Names of the variants.
        noise: Run this level of noise alone.
        seeds: How many runs of each; values are medians.
        watch: Receives the share that is done.

    Raises:
        UsageError: There is no such level of noise, or the setup does not fit the robot.
    """
    levels = [name for name in setup.noise if name != setup.curves.noise]
    if noise is not None and noise not in levels:
        raise UsageError(f"--noise {noise}: expected {one_of(levels)}")
    levels = [noise] if noise else levels
    # The missions of the loops take about as long as the reduced physics.
    reduced: Watch = watch if setup.loops is None else lambda share: watch(0.5 * share)
    work = _Work(profile, setup, seeds, reduced, len(parts) * (len(levels) + 1))
    for part in parts:
        for level in levels:
            work.run(part, level, setup.noise[level])
        work.run(part, _STICKING, setup.noise[levels[-1]], sticks=True)
    result = ExperimentResult(dict(_values(work)))
    result.figures = [*_places(work, levels), *_errors(work, levels)]
    if setup.curves.of in parts and noise is None:
        _add_curves(profile, setup, result)
    contact_values(profile, setup, result)
    if setup.sensitivity is not None and setup.sensitivity.of in parts:
        result.values |= _sensitivity(work, setup.sensitivity)
    if setup.loops is not None:
        made = repeat_with_loops(
            setup.loops, parts, seeds=seeds, watch=lambda share: watch(0.5 + 0.5 * share)
        )
        result.values |= made.values
        result.values |= _compared_with_partners(setup, parts, setup.loops.backend, result.values)
        result.notes += made.notes
        result.figures += made.figures
    return result


def _sensitivity(work: _Work, asked: Sensitivity) -> dict[str, float]:
    """Return the odometry error of a variant with one number changed at a time, by its name."""
    setup, noise = work.setup, work.setup.noise[asked.noise]
    changed = [
        *((name, {"speed": value}, noise) for name, value in asked.speed.items()),
        *((name, {"gain": value}, noise) for name, value in asked.gain.items()),
        *(
            (name, {}, noise.model_copy(update={"speed": value}))
            for name, value in asked.noise_speed.items()
        ),
    ]
    found = {}
    for name, control, level in changed:
        other = setup.model_copy(update={"control": setup.control.model_copy(update=control)})
        runs = [
            run_traction(work.profile, other, setup.variants[asked.of], level, seed=seed)
            for seed in range(work.seeds)
        ]
        found[f"{asked.of}.{name}.error"] = median(map(_error_m, runs))
    return found


@dataclass
class _Work:
    """Runs that have been made, by variant and level of noise."""

    profile: Profile
    setup: TractionSetup
    seeds: int
    watch: Watch
    total: int
    runs: dict[tuple[str, str], list[TractionRun]] = field(default_factory=dict)

    def run(self, part: str, level: str, noise: NoiseLevel, *, sticks: bool = False) -> None:
        self.watch(len(self.runs) / self.total)
        self.runs[part, level] = [
            run_traction(
                self.profile, self.setup, self.setup.variants[part], noise, seed=seed, sticks=sticks
            )
            for seed in range(self.seeds)
        ]

    def median(self, part: str, level: str, value: Callable[[TractionRun], float]) -> float:
        return median(value(run) for run in self.runs[part, level])


def _values(work: _Work) -> dict[str, float]:
    found: dict[str, float] = {}
    for part, level in work.runs:
        name = f"{part}.{level}"
        found[f"{name}.error"] = work.median(part, level, _error_m)
        found[f"{name}.way"] = work.median(part, level, lambda run: run.way_m)
        found[f"{name}.place"] = work.median(part, level, lambda run: float(run.place_m[-1]))
        found[f"{name}.jitter"] = work.median(part, level, lambda run: _jitter_m_s(work.setup, run))
    for level in dict.fromkeys(level for _, level in work.runs):
        found |= _compared_with_partners(work.setup, _parts(work), level, found)
    return found


def _compared_with_partners(
    setup: TractionSetup, parts: Iterable[str], level: str, values: Mapping[str, float]
) -> dict[str, float]:
    """Return how each compensated variant differs from the one that is not, at a level."""
    found: dict[str, float] = {}
    for part in parts:
        name, other = f"{part}.{level}", f"{_uncompensated(setup, part)}.{level}"
        if f"{name}.error" in values and f"{other}.error" in values:
            found[f"{name}.apart"] = abs(values[f"{name}.error"] - values[f"{other}.error"])
            found[f"{name}.kept"] = values[f"{name}.place"] - values[f"{other}.place"]
    return found


def _error_m(run: TractionRun) -> float:
    """Return the odometry error at the end, the mean of the wheels."""
    return abs(float(run.odometry_error_m[-1].mean()))


def _jitter_m_s(setup: TractionSetup, run: TractionRun) -> float:
    """Return how the speed varies while the robot is braked upright, its standard deviation."""
    begin = setup.timeline.turn.to
    end = min((each.begin for each in setup.timeline.drives if each.begin > begin), default=begin)
    braked = (run.times_s >= (begin + end) / 2) & (run.times_s < end)  # it has settled by then
    return float(run.speed_m_s[braked].std()) if braked.any() else 0.0


def _uncompensated(setup: TractionSetup, part: str) -> str | None:
    """Return the variant that differs from this one by gravity compensation alone."""
    its = setup.variants[part]
    if not its.compensated:
        return None
    others = setup.variants.items()
    return next((n for n, v in others if v.gripped == its.gripped and not v.compensated), None)


def _places(work: _Work, levels: list[str]) -> list[Plot]:
    return [
        Plot(
            f"Fig. 6-10, {level}: place in the pipe",
            "time, s",
            "x, m",
            tuple(
                PlotSeries(part, _thin(run.times_s), _thin(run.place_m), colour=number)
                for number, part in enumerate(_parts(work))
                for run in work.runs[part, level][:1]
            ),
        )
        for level in levels
    ]


def _errors(work: _Work, levels: list[str]) -> list[Plot]:
    """Return the odometry errors of all wheels, mean and standard deviation, at the last level."""
    series = []
    for number, part in enumerate(_parts(work)):
        run = work.runs[part, levels[-1]][0]
        errors = run.odometry_error_m[::_DRAWN]
        mean, spread = errors.mean(axis=1), errors.std(axis=1)
        times = _thin(run.times_s)
        low, high = (mean - spread).tolist(), (mean + spread).tolist()
        series += [
            PlotSeries("", times, low, "band", high, colour=number),
            PlotSeries(part, times, mean.tolist(), colour=number),
        ]
    title = f"Fig. 6-11, {levels[-1]}: odometry error, mean and std. of the wheels"
    return [Plot(title, "time, s", "x - r sum(w dt), m", tuple(series))]


def _parts(work: _Work) -> list[str]:
    return list(dict.fromkeys(part for part, _ in work.runs))


def _thin(values: np.ndarray) -> list[float]:
    thinned: list[float] = values[::_DRAWN].tolist()
    return thinned


def _add_curves(profile: Profile, setup: TractionSetup, result: ExperimentResult) -> None:
    """Fit the slip curves of the run apart, and draw fig. 6-12 of its first wheel."""
    curves = setup.curves
    run = run_traction(profile, setup, setup.variants[curves.of], setup.noise[curves.noise])
    names = [wheel.name for wheel in profile.body.wheels]
    driven = run.times_s > max(setup.timeline.clamp.values())
    for number, wheel in enumerate(curves.wheels):
        at = names.index(wheel)
        slip, used = run.slip_m_s[driven, at], run.used_friction[driven, at]
        curve = fit_slip_curve(slip, used, setup.physics.threshold)
        result.values |= _curve_values(f"{curves.of}.{wheel}", curve)
        if number == 0:
            speed = run.speed_m_s[driven]
            ratio = -slip / np.where(np.abs(speed) < 0.005, np.nan, speed)
            what = "|v - w r|, m/s"
            result.figures += [
                _cloud("Fig. 6-12a: friction over slip ratio", "slip ratio", ratio, used),
                _cloud("Fig. 6-12b: friction over slip speed", what, np.abs(slip), used),
                slip_plot(curve, "Fig. 6-12c: both fits"),
            ]


def _curve_values(name: str, curve: SlipCurve) -> dict[str, float]:
    return {
        f"{name}.static": curve.static.value,
        f"{name}.kinetic": curve.kinetic.value,
        f"{name}.process_peak": curve.process_peak.value,
        f"{name}.magic_plateau": curve.magic_plateau.value,
        f"{name}.magic_peak": curve.magic_peak.value,
    }


def _cloud(title: str, x_label: str, x: np.ndarray, y: np.ndarray) -> Plot:
    shown = (np.abs(x) <= 1) & np.isfinite(y)
    step = max(int(np.count_nonzero(shown)) // 1500, 1)
    dots = PlotSeries("", x[shown][::step].tolist(), y[shown][::step].tolist(), "dots")
    return Plot(title, x_label, "friction in use |F| / N", (dots,))
