"""`pirate forecast`: says how long the phases of a mission take, from earlier runs."""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.cli.errors import say
from pirate_sm.cli.options.recordings import ForecastOptions
from pirate_sm.cli.output.files import is_recording, refuse_losses, write_file
from pirate_sm.cli.output.terminal import progress, writable
from pirate_sm.core.errors import RecordingError, UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.on_disk import is_folder
from pirate_sm.core.visible import visible
from pirate_sm.running.recording.forecast_file import (
    CountedRun,
    ForecastFile,
    counted,
    counted_run,
    forecast_of,
    unlike,
)
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.running.runtime.phase_times import LEAST_RUNS, EarlierRuns
from pirate_sm.running.wiring import Order

if TYPE_CHECKING:
    from pirate_sm.running.recording.signal_bands import RunExtremes, SignalBands
    from pirate_sm.views.report.contents import Report

ENOUGH, TOO_FEW = 0, 1


class _Source(NamedTuple):
    """A run, and what returns between which values its curves ran."""

    run: CountedRun
    extremes: Callable[[], RunExtremes]


def make_forecast(options: ForecastOptions) -> int:
    """Print how long phases take, and write it to a file; return the exit code.

    Raises:
        LoadError: The mission or the campaign has faults.
        UsageError: No run can be used, the file cannot be written, or none is named for signals.
    """
    if options.signals and options.output is None:
        raise UsageError("--signals is for a file: name it with --output")
    refuse_losses([options.output], inputs=map(Path, options.paths), overwrite=options.overwrite)
    runs = list(_rehearsed(options) if options.rehearse else _recorded(options))
    found, kept, others = _alike(runs)
    for why, number in others.items():
        say(f"{number} of {len(runs)} runs are not counted: {why}")
    if options.signals:
        found = found.model_copy(update={"signals": _signals(kept)})
    if options.output is not None:
        write_file(options.output, found.text())
    forecast = found.times
    for line in _lines(found, forecast):
        print(writable(visible(line)))
    return TOO_FEW if forecast.whole is None else ENOUGH


def _recorded(options: ForecastOptions) -> Iterator[_Source]:
    """Yield what the recordings say; those that cannot be read are named."""
    paths = [found for place in options.paths for found in _recordings(Path(place))]
    with progress("reading recordings") as watch:
        for number, path in enumerate(paths):
            watch(number / len(paths))
            try:
                run = counted(read_recording(path))
            except RecordingError as error:
                say(str(error))
                continue
            if options.mission in (None, run.header.mission):
                yield _Source(run, partial(_extremes, partial(_replayed, path)))


def _recordings(place: Path) -> Sequence[Path]:
    if is_folder(place):
        return sorted(place.rglob("*.mcap"))
    if place.suffix != ".mcap" and not is_recording(place):
        raise UsageError(
            f"'{place}' is neither a recording nor a folder: --rehearse N runs a mission"
        )
    return [place]


def _replayed(path: Path) -> Report:
    from pirate_sm.views.report.recording_report import report_of

    return report_of(read_recording(path))


def _extremes(report: Callable[[], Report]) -> RunExtremes:
    from pirate_sm.views.report.expected_signals import run_extremes

    return run_extremes(report())


def _signals(sources: Sequence[_Source]) -> SignalBands | None:
    """Return the bands of the signals, and say of how many runs they are; None if there are none.

    They are made of the last runs, as many as make a difference.
    """
    from pirate_sm.running.recording.signal_bands import MOST_RUNS, signal_bands

    runs: list[RunExtremes] = []
    last = sources[-MOST_RUNS:]
    with progress("replaying runs for their signals") as watch:
        for number, each in enumerate(last):
            watch(number / len(last))
            runs.append(each.extremes())
    found = signal_bands(runs)
    if found is None:
        say(f"there are no bands of signals: {LEAST_RUNS} runs are needed in a phase of a second")
    else:
        curves = {curve[:2] for phase in found.phases for curve in phase.curves}
        say(f"bands of {len(curves)} curves in {len(found.phases)} phases, of {len(runs)} runs")
    return found


def _rehearsed(options: ForecastOptions) -> Iterator[_Source]:
    """Yield runs in the simulator."""
    from pirate_sm.lab.coverage.evidence import played

    planned = _planned(options)
    with progress("rehearsing in the simulator") as watch:
        for number, (order, loaded) in enumerate(planned):
            watch(number / len(planned))
            run = played(order, loaded).run
            steps = ((step.effects, step.at_s) for step in run.steps())
            again = partial(_played_again, order, loaded)
            yield _Source(counted_run(run.header, steps), partial(_extremes, again))


def _played_again(order: Order, loaded: LoadedMission) -> Report:
    """Return the report of a run in the simulator, which is the same each time."""
    from pirate_sm.lab.coverage.evidence import played

    return played(order, loaded).run.contents()


def _planned(options: ForecastOptions) -> list[tuple[Order, LoadedMission]]:
    """Return the runs of the mission or of the cell of the campaign, with all seeds."""
    from pirate_sm.core import library
    from pirate_sm.lab.campaign.campaign_file import read_campaign
    from pirate_sm.lab.campaign.plan import varied

    if len(options.paths) != 1:
        raise UsageError("--rehearse takes one mission or one campaign")
    (named,) = options.paths
    path = Path(named) if library.is_path(named) else library.find_mission(named)
    plan = read_campaign(path, range(options.rehearse), check=False)
    cells = [each for each in plan.cells if options.cell in (None, each.name)]
    if len(cells) != 1:
        names = ", ".join(f"'{each.name}'" for each in plan.cells)
        raise UsageError(f"name one cell with --cell: {names}")
    (cell,) = cells
    loaded: LoadedMission = pickle.loads(plan.missions[cell.mission])
    seeds = cell.seeds if cell.design is None else ()
    return [(varied(cell, seed, {}), loaded) for seed in seeds]


def _alike(
    sources: Sequence[_Source],
) -> tuple[ForecastFile, Sequence[_Source], Counter[str]]:
    """Return the forecast from the runs that are like the newest one, them, and why others are not.

    Raises:
        UsageError: There is no run to count.
    """
    others = Counter(each.run.why_not for each in sources if each.run.why_not)
    usable = [each for each in sources if not each.run.why_not]
    if not usable:
        why = "; ".join(f"{why} ({number})" for why, number in others.items())
        raise UsageError(f"there is no run that can be counted{': ' if why else ''}{why}")
    usable.sort(key=lambda each: datetime.fromisoformat(each.run.header.began))
    newest, kept = usable[-1].run.header, list[_Source]()
    for each in usable:
        header = each.run.header
        why = unlike(forecast_of(header), forecast_of(newest))
        if not why and header.backend != newest.backend:
            why = f"on the backend {header.backend}, not on {newest.backend}"
        others.update([why] if why else ())
        kept += [] if why else [each]
    return forecast_of(newest, [each.run.visits for each in kept]), kept, others


def _lines(found: ForecastFile, forecast: EarlierRuns) -> Iterator[str]:
    """Yield a line for each phase, and one for the whole run."""
    pipe = f" in {found.pipe}" if found.pipe else ""
    yield f"{found.forecast} on {found.robot}{pipe}: {forecast.of(len(found.runs))} that succeeded"
    yield ""
    wide = max((len(key.words) for key in forecast.keys), default=5)
    yield f"{'phase':<{wide}}  runs   median  90 % of runs         slow after"
    for key in forecast.keys:
        if not forecast.matters(key):
            continue
        times_s, usual, slow = forecast.times_s(key), forecast.usual(key), forecast.slow(key)
        middle = f"{times_s[len(times_s) // 2]:7.1f} s"
        band = "too few runs" if usual is None else usual.words
        after = "" if slow is None else f"{slow.limit_s:7.1f} s"
        yield f"{key.words:<{wide}}  {len(times_s):4}  {middle}  {band:<18}  {after}".rstrip()
    yield ""
    yield forecast.notice.removeprefix("forecast: ")
