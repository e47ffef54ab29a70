"""`pirate fit --robot`: the numbers of a robot that nobody measured, from recordings of it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.options.estimates import FitOptions
from pirate_sm.cli.output.csv_table import write_csv
from pirate_sm.cli.output.estimate_text import estimate_text
from pirate_sm.cli.output.files import write_file
from pirate_sm.cli.output.progress import progress
from pirate_sm.errors import UsageError
from pirate_sm.visible import visible

if TYPE_CHECKING:
    from pirate_sm.model.profile import Profile

NOTHING = 1
ROBOT_HEADER = ("motor", "number", "unit", "value", "low", "high", "reason")


def fit_robot(options: FitOptions) -> int:
    """Print the robot's numbers and write them for its simulator; return the exit code.

    Raises:
        RecordingError: A recording cannot be read.
        UsageError: The recordings are of several robots, or a file cannot be written.
    """
    from pirate_sm.fitting.columns import read_measured
    from pirate_sm.fitting.robot_numbers import robot_numbers
    from pirate_sm.fitting.twin_text import twin_text

    with progress("reading") as watch:
        measured = []
        for number, run in enumerate(options.runs):
            watch(number / len(options.runs))
            measured.append(read_measured(Path(run)))
    profile = _one_robot([each.profile for each in measured])
    numbers = robot_numbers(measured)
    for each in numbers:
        what = f"{each.motor} {each.key}".strip()
        print(visible(f"{what:<26} {estimate_text(each.estimate, f' {each.unit}'.rstrip())}"))
    if options.csv:
        rows = [(n.motor, n.key, n.unit, n.estimate.value, n.estimate.low, n.estimate.high,
                 n.estimate.reason) for n in numbers]  # fmt: skip
        write_csv(options.csv, ROBOT_HEADER, rows)
    if options.write:
        source = ", ".join(Path(run).name for run in options.runs)
        write_file(options.write, twin_text(profile, numbers, source))
        print(visible(str(options.write)))
    return 0 if any(each.estimate.known for each in numbers) else NOTHING


def _one_robot(profiles: list[Profile | None]) -> Profile:
    """Return the profile of the robot that all recordings are of."""
    known = [profile for profile in profiles if profile is not None]
    if len(known) < len(profiles):
        raise UsageError("a table does not say what the robot was commanded: give recordings")
    names = {profile.robot for profile in known}
    if len(names) > 1:
        raise UsageError(f"the recordings are of several robots: {', '.join(sorted(names))}")
    return known[0]
