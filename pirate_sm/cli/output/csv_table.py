"""Writes a table of what a command has found."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from pathlib import Path

from pirate_sm.cli.output.files import write_file


def write_csv(place: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; an unknown number is an empty cell.

    Raises:
        UsageError: The file cannot be written.
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow(["" if each != each else each for each in row])  # noqa: PLR0124
    write_file(place, text.getvalue())


def csv_line(header: Sequence[str]) -> str:
    """Return the first line of a table."""
    return ",".join(header)
