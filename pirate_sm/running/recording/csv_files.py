"""Write the tables of a recording as CSV files."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.tables import PLACES, TableRow, write_files


def write_tables(recording: Recording, loaded: LoadedMission, folder: Path) -> tuple[Path, ...]:
    """Write each topic of the recording to a CSV file in the folder, and return the files.

    Raises:
        OSError: The folder cannot be written.
        RecordingError: The recording is damaged or empty.
    """
    return write_files(recording, loaded, folder, ".csv", _CsvFile)


class _CsvFile:
    """A table as CSV, which begins with its header."""

    def __init__(self, path: Path, first: TableRow) -> None:
        self._file = path.open("w", encoding="utf-8", newline="")
        self._writer = csv.writer(self._file)
        self._writer.writerow(first.header)

    def add(self, row: TableRow) -> None:
        values = row.values
        if row.table == PLACES:
            values = (*values[:2], *map(_shortest, values[2:]))
        self._writer.writerow(map(_cell, values))

    def close(self) -> None:
        self._file.close()


def _shortest(value: float) -> float:
    """Return the number; a whole one as an integer, which is written without a point."""
    return int(value) if float(value).is_integer() else value


def _cell(value: Any) -> Any:
    """Return the value as a cell; an unknown number is empty, which pandas and Matlab read as NaN.

    Text from a mission must not begin a formula in a spreadsheet, so an apostrophe before it
    keeps it text.
    """
    if isinstance(value, str) and value.startswith(_FORMULAS):
        return f"'{value}"
    return "" if isinstance(value, float) and value != value else value  # noqa: PLR0124


_FORMULAS = ("=", "+", "-", "@", "\t", "\r")
"""Characters that begin a formula in a spreadsheet (OWASP, CSV injection)."""
