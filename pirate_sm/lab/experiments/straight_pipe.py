"""Repeats an experiment up and down a straight pipe: table 6-1 and figures 6-1 to 6-8."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import numpy as np

from pirate_sm.api import Run, run
from pirate_sm.core.profile import Profile, Wheel
from pirate_sm.lab.experiments.experiment_result import ExperimentResult, Watch
from pirate_sm.lab.experiments.mission_setups import StraightPipeSetup
from pirate_sm.lab.experiments.needed_extras import is_missing
from pirate_sm.lab.experiments.slip_signals import SlipSignals
from pirate_sm.lab.fitting.slip_curve import fit_slip_curve
from pirate_sm.lab.fitting.slip_plot import slip_plot
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.simulation.arrays import Floats
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries


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
        if part == setup.shown:
            result.figures += _figures(signals, wheels, profile)
    for number, part in enumerate(further, start=len(parts)):
        watch(number * share)
        backend, pipe = setup.again[part].backend, setup.again[part].pipe
        title, why = f"{part} on {backend}", is_missing(backend)
        if why:
            result.notes.append(f"{title}: not run, {why}")
            continue
        made = run(setup.missions[part], backend, pipe=pipe, defects=setup.defects)
        signals = SlipSignals(made, setup.processing)
        _take_in(result, f"{part}.{backend}", title, signals, wheels)
    for number, part in enumerate(seen, start=len(parts) + len(further)):
        watch(number * share)
        title, why = f"{part} by the camera {setup.seen[part]}", is_missing("vision")
        if why:
            result.notes.append(f"{title}: not run, {why}")
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
        torque = float(np.median(np.abs(signals.joint_torque(joint.name))))
        result.values[f"{name}.{joint.name}.torque_median"] = torque


def _wheel_values(signals: SlipSignals, wheel: Wheel) -> dict[str, float]:
    """Return the statistics of table 6-1 and what section 6-2 says of friction."""
    ratio = signals.ratio(wheel)
    ratio = ratio[np.isfinite(ratio)]
    driving = np.abs(signals.speed_m_s) >= signals.processing.driving_above
    driven = signals.ratio(wheel)[driving]
    within = ratio[np.abs(ratio) <= signals.processing.most_ratio]
    return {
        "driving_median": _or_nan(np.median, driven),
        "driving_mean": _or_nan(np.mean, driven),
        "driving_std": _or_nan(np.std, driven),
        "within_mean": _or_nan(np.mean, within),
        "within_std": _or_nan(np.std, within),
        "least": _or_nan(np.min, ratio),
        "most_friction": _or_nan(np.nanmax, signals.friction(wheel)),
    }


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
