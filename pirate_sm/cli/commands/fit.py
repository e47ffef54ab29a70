"""`pirate fit`: slip and friction from recordings, or the numbers of a robot."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import fields
from math import isnan
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from pirate_sm.cli.options.declaring import read_length, read_slip_speed
from pirate_sm.cli.options.estimates import FitOptions
from pirate_sm.cli.output.files import (
    csv_line,
    refuse_losses,
    write_and_name,
    write_csv,
    write_file,
)
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import missions
from pirate_sm.core.models import Profile
from pirate_sm.core.visible import visible
from pirate_sm.lab.fitting.measurements import (
    Estimate,
    MeasuredFile,
    SlipSignalNames,
    read_measured,
    slip_and_friction,
    steady,
    wheels_in,
)
from pirate_sm.simulation.arrays import Floats

if TYPE_CHECKING:
    from pirate_sm.lab.fitting.slip_curve import SlipCurve  # needs SciPy


NOTHING = 1

_OF_CURVES = ("slip", "friction", "torque", "normal", "radius", "threshold")
"""Options for curves of slip and friction alone."""

_LEAST = 0.05
"""Numbers that narrow by less are not printed; files have them all."""

_PREDICTED_HEADER = ("kind", "board", "command", "place", "nth", "from_s", "low", "high",
                     "recorded", "held")  # fmt: skip
_ADVISED_HEADER = ("mission", "number", "gain", "error", "takes_s", "succeeded", "robots")
_ROBOT_HEADER = ("motor", "number", "unit", "value", "low", "high", "reason")


def run_fit(options: FitOptions) -> int:
    """Print what recordings say of slip and friction, or of the robot; return the exit code.

    Raises:
        RecordingError: A recording cannot be read.
        UsageError: A signal is missing, an option does not fit, or a file cannot be written.
    """
    _refuse_losses(options)
    _refuse_unfitting(options)
    if options.predict:
        return _predict(options)
    if options.advise:
        return _advise(options)
    if options.format != "text" or (options.workers, options.robots) != (None, None):
        raise UsageError("--format, --robots and --workers go with --predict and --advise")
    if options.robot:
        return _fit_robot(_measured(options.runs), options)
    curves = _curves(options)
    for wheel, curve in curves.items():
        for line in _lines(wheel, curve):
            print(visible(line))
    if options.csv:
        write_csv(options.csv, _HEADER, [row for item in curves.items() for row in _rows(*item)])
        print(visible(str(options.csv)))
    if options.output:
        write_and_name(options.output, _page(curves, options))
    _say_friction(curves, options.write)
    return (
        0 if any(each.static.known or each.kinetic.known for each in curves.values()) else NOTHING
    )


def _refuse_unfitting(options: FitOptions) -> None:
    """Refuse options that do not go together.

    Raises:
        UsageError: There are such options.
    """
    of_curves = [
        f"--{each.name}"
        for each in fields(options)
        if each.name in _OF_CURVES and getattr(options, each.name) != each.default
    ]
    if options.robot and of_curves:
        raise UsageError(f"{', '.join(of_curves)}: only for slip and friction, without --robot")
    if options.predict and options.advise:
        raise UsageError("--predict and --advise cannot be given together")


def _measured(runs: Sequence[str]) -> list[MeasuredFile]:
    with progress("reading") as watch:
        measured = []
        for number, run in enumerate(runs):
            watch(number / len(runs))
            measured.append(read_measured(Path(run)))
    return measured


def _refuse_losses(options: FitOptions) -> None:
    """Refuse to write over other files; a pipe file is changed in place, which is meant."""
    runs = list(map(Path, options.runs))
    places = [each for each in (options.output, options.csv) if each]
    tables = [csv_line(_HEADER), csv_line(_ROBOT_HEADER), csv_line(_PREDICTED_HEADER),
              csv_line(_ADVISED_HEADER)]  # fmt: skip
    if options.write is not None and options.robot:
        places.append(options.write)
    elif options.write is not None:
        refuse_losses([*places, options.write], inputs=runs, tables=tables, overwrite=True)
        runs.append(options.write)
    refuse_losses(places, inputs=runs, tables=tables, overwrite=options.overwrite)


def _signals(options: FitOptions, measured: MeasuredFile) -> SlipSignalNames:
    radius_m = read_length("--radius", options.radius)
    if radius_m is None and measured.profile is not None:
        radius_m = measured.profile.body.wheel_radius
    return SlipSignalNames(
        options.slip, options.friction, options.torque, options.normal, radius_m or 0.0
    )


def _curves(options: FitOptions) -> dict[str, SlipCurve]:
    """Return the curve of each wheel."""
    from pirate_sm.lab.fitting.slip_curve import fit_slip_curve

    measured = _measured(options.runs)
    threshold = read_slip_speed("--threshold", options.threshold)
    wheels = wheels_in(measured[0].columns, _signals(options, measured[0]))
    curves = {}
    with progress("fitting") as watch:
        for number, wheel in enumerate(wheels):
            watch(number / len(wheels))
            pairs = [_points(each, wheel, options) for each in measured]
            slip, friction = (np.concatenate(each) for each in zip(*pairs, strict=True))
            curves[wheel] = fit_slip_curve(slip, friction, threshold)
    return curves


def _points(measured: MeasuredFile, wheel: str, options: FitOptions) -> tuple[Floats, Floats]:
    """Return slip and friction of a wheel; of a recording where they are steady."""
    slip, friction = slip_and_friction(measured.columns, wheel, _signals(options, measured))
    if measured.profile is None:
        return slip, friction
    return steady(measured.columns["time_s"], slip, friction)


def _values(curve: SlipCurve) -> Iterable[tuple[str, Estimate]]:
    yield "static, directly", curve.static
    yield "kinetic, directly", curve.kinetic
    yield "peak of the Magic formula", curve.magic_peak
    yield "its plateau", curve.magic_plateau
    yield "peak of the Gaussian process", curve.process_peak


def _lines(wheel: str, curve: SlipCurve) -> Iterable[str]:
    """Yield what is printed of a wheel."""
    name = f"wheel {wheel}" if wheel else "all"
    yield f"{name}: {curve.points} points, slip up to {curve.most_slip_m_s * 1000:.1f} mm/s"
    for what, estimate in _values(curve):
        yield f"  {what:<29} {estimate_text(estimate)}"
    if curve.magic is not None and (curve.magic_peak.known or curve.magic_plateau.known):
        from pirate_sm.lab.fitting.slip_curve import NAMES

        numbers = zip(NAMES, curve.magic.parameters, curve.magic.interval, strict=True)
        parameters = ", ".join(f"{each} {value:.4g} ± {half:.2g}" for each, value, half in numbers)
        yield f"  Magic formula: {parameters}; misfit {curve.magic.misfit:.4f} (rms)"


_HEADER = ("wheel", "what", "value", "low", "high", "reason")


def _rows(wheel: str, curve: SlipCurve) -> Iterable[tuple[object, ...]]:
    for what, each in _values(curve):
        yield (wheel, what, each.value, each.low, each.high, each.reason)


def _page(curves: dict[str, SlipCurve], options: FitOptions) -> str:
    from pirate_sm.lab.fitting.slip_curve import slip_plot
    from pirate_sm.views.report.figure_page import FigureSection, figure_page

    sections = [
        FigureSection(
            f"Wheel {wheel}" if wheel else "All",
            lines=list(_lines(wheel, curve))[-1:],
            header=("", "value and 95 % interval"),
            rows=[(what, estimate_text(each)) for what, each in _values(curve)],
            plots=[slip_plot(curve, "Friction over slip speed")],
        )
        for wheel, curve in curves.items()
    ]
    return figure_page(f"Slip and friction: {', '.join(options.runs)}", sections)


def _say_friction(curves: dict[str, SlipCurve], place: Path | None) -> None:
    """Print the friction of a simulated pipe, or write it into a pipe file.

    Raises:
        UsageError: It is to be written and is not known, or the file is not a pipe.
    """
    from pirate_sm.lab.fitting.slip_curve import friction_line, pipe_with_friction

    found = [
        [each.value for each in estimates if each.known]
        for estimates in zip(*((c.static, c.kinetic) for c in curves.values()), strict=True)
    ]
    if not all(found):
        if place is not None:
            missing = "static" if not found[0] else "kinetic"
            raise UsageError(f"{missing} friction is unknown: nothing is written into '{place}'")
        return
    static, kinetic = map(median, found)
    if place is None:
        print(f"for a pipe file (medians of the wheels): {friction_line(static, kinetic)}")
        return
    write_file(place, pipe_with_friction(place, static, kinetic))
    print(visible(f"{place}: {friction_line(static, kinetic)}"))


def _fit_robot(measured: Sequence[MeasuredFile], options: FitOptions) -> int:
    """Print the robot's numbers and write them for its simulator; return the exit code.

    Raises:
        UsageError: The recordings are of several robots, or a file cannot be written.
    """
    from pirate_sm.lab.fitting.robot_numbers import robot_numbers
    from pirate_sm.lab.fitting.twin_file import twin_text

    profile = _one_robot([each.profile for each in measured])
    numbers = robot_numbers(measured)
    for each in numbers:
        what = f"{each.motor} {each.key}".strip()
        print(visible(f"{what:<26} {estimate_text(each.estimate, f' {each.unit}'.rstrip())}"))
    if options.csv:
        rows = [(n.motor, n.key, n.unit, n.estimate.value, n.estimate.low, n.estimate.high,
                 n.estimate.reason) for n in numbers]  # fmt: skip
        write_csv(options.csv, _ROBOT_HEADER, rows)
    if options.write:
        source = ", ".join(Path(run).name for run in options.runs)
        write_and_name(options.write, twin_text(profile, numbers, source))
    return 0 if any(each.estimate.known for each in numbers) else NOTHING


def _predict(options: FitOptions) -> int:
    """Print which bands hold what was recorded in the second half; return the exit code.

    Raises:
        RecordingError: The recording cannot be read.
        UsageError: The options do not fit, or no robot can run the mission.
    """
    if not options.robot or len(options.runs) != 1 or options.write or options.output:
        raise UsageError("--predict goes with --robot and one recording, without --write and -o")
    from pirate_sm.lab.fitting.prediction import LEAST_ROBOTS, SHARE, UNITS, coverage, predict
    from pirate_sm.lab.fitting.twin_file import ROBOTS

    robots = ROBOTS if options.robots is None else options.robots
    if robots < LEAST_ROBOTS:
        raise UsageError(f"--robots {robots} are too few to predict: give at least {LEAST_ROBOTS}")
    with progress("simulating") as watch:
        made = predict(Path(options.runs[0]), robots, options.workers, watch)
    found = made.predicted
    rows = [(*each.quantity, each.from_s, each.low, each.high, each.recorded, each.held)
            for each in found]  # fmt: skip
    if options.csv:
        write_csv(options.csv, _PREDICTED_HEADER, rows)
    counts = coverage(found)
    if options.format == "json":
        kinds = {kind: {"held": held, "of": of, "widened": made.widened[kind]._asdict()}
                 for kind, (held, of) in counts.items()}  # fmt: skip
        listed = [dict(zip(_PREDICTED_HEADER, row, strict=True)) for row in rows]
        print(json.dumps({"format": 1, "share": SHARE, "kinds": kinds, "predicted": listed,
                          "left_out": made.left_out, "robots": made.robots,
                          "failed": made.failed}))  # fmt: skip
        return 0 if found else NOTHING
    for each in found:
        kind, board, command, *_ = each.quantity
        what = f"{command}, {kind}{f' of board {board}' if board else ''}"
        band = f"[{each.low:.3g}, {each.high:.3g}] {UNITS[kind]}"
        missed = "" if each.held else " !"
        print(visible(f"{each.from_s:8.1f} s  {what:<36} {band:<26} {each.recorded:.3g}{missed}"))
    for kind, (held, of) in counts.items():
        by = made.widened[kind]
        few = f"not widened: only {by.values} values"
        how = f"widened {by.factor:.2f} times" if by.known else few
        print(f"{kind:<9} {held} of {of} in the {SHARE:.0%} band, {how}")
    for reason, count in made.left_out.items():
        print(f"left out  {count}: {reason}")
    if made.failed:
        print(f"{made.failed} of {made.robots} robots cannot run the mission")
    return 0 if found else NOTHING


def _advise(options: FitOptions) -> int:
    """Print how much each shipped mission is expected to show; return the exit code.

    Raises:
        RecordingError: A recording cannot be read.
        UsageError: The options do not fit, or no robot can run a shipped mission.
    """
    if not options.robot or options.write or options.output:
        raise UsageError("--advise goes with --robot, without --write and -o")
    from pirate_sm.lab.fitting import advice

    measured = _measured(options.runs)
    _one_robot([each.profile for each in measured])
    robots = advice.ROBOTS if options.robots is None else options.robots
    with progress("simulating") as watch:
        advised = advice.advise(measured, missions(), robots, options.workers, watch)
    if options.csv:
        rows = [(one.mission, number, *gain, one.takes_s, one.succeeded, one.robots)
                for one in advised.missions
                for number, gain in (("all, bits", one.bits), *one.narrower.items())]  # fmt: skip
        write_csv(options.csv, _ADVISED_HEADER, rows)
    if options.format == "json":
        print(json.dumps({"format": 1, "advised": [each.as_data() for each in advised.missions],
                          "left_out": advised.left_out, "robots": advised.robots,
                          "rejected": advised.rejected,
                          "unchecked": advised.unchecked}))  # fmt: skip
        return 0
    for one in advised.missions:
        numbers = sorted(one.narrower.items(), key=lambda item: -item[1].mean)
        shown = [f"{name} by {share.mean:.0%}" for name, share in numbers if share.mean >= _LEAST]
        gain = f"{one.bits.mean:5.2f} ± {one.bits.error:.2f} bits"
        ends = f"{one.takes_s:5.0f} s, {one.succeeded} of {one.robots} succeed"
        print(visible(f"{gain}  {one.mission:<26} {ends}; narrows {', '.join(shown) or 'nothing'}"))
    for mission, reason in advised.left_out.items():
        print(visible(f"left out  {mission}: {reason}"))
    count = f"{advised.rejected} of {advised.rejected + advised.robots}"
    print(f"rejected  {count} robots: they end a recorded mission differently")
    if advised.unchecked:
        print(visible(f"not all recordings could reject robots: {advised.unchecked}"))
    return 0


def _one_robot(profiles: list[Profile | None]) -> Profile:
    """Return the profile of the robot that all recordings are of."""
    known = [profile for profile in profiles if profile is not None]
    if len(known) < len(profiles):
        raise UsageError("a table does not say what the robot was commanded: give recordings")
    names = {profile.robot for profile in known}
    if len(names) > 1:
        raise UsageError(f"the recordings are of several robots: {', '.join(sorted(names))}")
    return known[0]


def estimate_text(estimate: Estimate, unit: str = "") -> str:
    """Return a value with its 95 % interval, or why it is unknown."""
    if not estimate.known:
        bound = "" if isnan(estimate.low) else f"at least {estimate.low:.3f}{unit}, "
        return f"{bound}unknown: {estimate.reason}"
    if isnan(estimate.low):
        return f"{estimate.value:.3f}{unit}"
    return f"{estimate.value:.3f}{unit} [{estimate.low:.3f}, {estimate.high:.3f}]"
