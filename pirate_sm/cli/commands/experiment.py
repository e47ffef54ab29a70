"""`pirate experiment`: the thesis's experiments again, its values next to ours."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from math import isnan
from pathlib import Path
from textwrap import wrap
from time import perf_counter
from typing import TYPE_CHECKING

from pirate_sm.cli.options.estimates import ExperimentOptions
from pirate_sm.cli.output.files import csv_line, refuse_losses, write_csv, write_file
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core.visible import visible

if TYPE_CHECKING:
    from pirate_sm.core.models import Profile
    from pirate_sm.lab.experiments.experiment_files import Setup
    from pirate_sm.lab.experiments.setups import ExperimentResult
    from pirate_sm.lab.experiments.thesis_rows import ComparedRow


NOT_ALL_HOLD = 1
_WIDE = 100


def run_experiment(options: ExperimentOptions) -> int:
    """Repeat the experiments that are asked for and print each row; return the exit code.

    Raises:
        LoadError: A file of the robot, of an experiment or of a mission cannot be used.
        UsageError: There is no such experiment, or the simulator is not installed.
    """
    places = options.output, options.csv
    refuse_losses(places, tables=[csv_line(_HEADER)], overwrite=options.overwrite)
    from pirate_sm.core import library
    from pirate_sm.core.loading import load_robot
    from pirate_sm.lab.experiments.experiment_files import chosen, load_experiments
    from pirate_sm.lab.experiments.thesis_rows import FAILED, compared
    from pirate_sm.views.report.figure_page import FigureSection, figure_page

    folder = library.find_robot(options.robot, Path.cwd())
    profile = load_robot(folder).profile
    every: list[ComparedRow] = []
    notes: list[str] = []
    sections = []
    for setup, parts in chosen(load_experiments(folder), options.which):
        began = perf_counter()
        result = _repeated(profile, setup, parts, options)
        rows = [each for each in compared(setup.rows, result.values) if each.row.of in parts]
        took = f"repeated in {perf_counter() - began:.0f} s"
        if options.format == "text":
            print(f"Experiment {setup.experiment}: {setup.title} ({took})")
            for line in [*(f"  {note}" for note in result.notes), *_lines(rows), ""]:
                print(visible(line))
        every += rows
        notes += result.notes
        title = f"Experiment {setup.experiment}: {setup.title}"
        table = [_cells(each) for each in rows]
        sections.append(FigureSection(title, result.notes, _HEADER, table, result.figures))
    if options.csv:
        write_csv(options.csv, _HEADER, map(_cells, every))
    if options.output:
        write_file(options.output, figure_page("The thesis's experiments, repeated", sections))
    if options.format == "text":
        for place in filter(None, (options.csv, options.output)):
            print(visible(str(place)))
    print(_as_json(every, notes) if options.format == "json" else _summary(every))
    return NOT_ALL_HOLD if any(each.verdict in FAILED for each in every) else 0


def _repeated(
    profile: Profile, setup: Setup, parts: tuple[str, ...], options: ExperimentOptions
) -> ExperimentResult:
    """Return what came of an experiment."""
    from pirate_sm.lab.experiments.bend import repeat_bend
    from pirate_sm.lab.experiments.setups import BendSetup, TractionSetup
    from pirate_sm.lab.experiments.straight_pipe import repeat_straight_pipe
    from pirate_sm.lab.experiments.traction_experiment import repeat_traction

    with progress(f"experiment {setup.experiment}") as watch:
        if isinstance(setup, TractionSetup):
            noise, seeds = options.noise, options.seeds
            return repeat_traction(profile, setup, parts, noise=noise, seeds=seeds, watch=watch)
        if isinstance(setup, BendSetup):
            return repeat_bend(setup, parts, seeds=options.seeds, watch=watch)
        return repeat_straight_pipe(profile, setup, parts, watch=watch)


_HEADER = ("part", "what", "thesis", "band", "ours", "verdict", "place in the thesis")


def _cells(each: ComparedRow) -> tuple[str, ...]:
    row = each.row
    values = row.thesis, each.band_text, each.ours_text
    return (row.of, row.what, *values, each.verdict_text, row.place)


def _lines(rows: list[ComparedRow]) -> Iterator[str]:
    """Yield the table: values side by side, then the verdict with its reason."""
    wide = max((len(each.row.what) for each in rows), default=0)
    for each in rows:
        row = each.row
        band = f", band {each.band_text} ({row.source})" if row.between else ""
        values = f"thesis {row.thesis} ({row.place}){band}, ours {each.ours_text}"
        yield f"  {row.of:<3} {row.what:<{wide}}  {values}"
        indent = " " * 6
        yield from wrap(each.verdict_text, _WIDE, initial_indent=indent, subsequent_indent=indent)


def _summary(rows: list[ComparedRow]) -> str:
    counts = Counter(each.verdict for each in rows)
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "no rows"


def _as_json(rows: list[ComparedRow], notes: list[str]) -> str:
    """Return every row with its verdict, what they add up to, and the notes."""
    judged = [
        each.row.model_dump(exclude={"cannot"})
        | {"ours": None if isnan(each.ours) else each.ours, "verdict": each.verdict}
        for each in rows
    ]
    counted = {"counts": Counter(each.verdict for each in rows), "notes": notes, "rows": judged}
    return json.dumps(counted, indent=1, ensure_ascii=False)
