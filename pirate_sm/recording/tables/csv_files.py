"""A recording as tables, one for each topic, with SI units in the headers."""

from __future__ import annotations

import csv
from contextlib import ExitStack, suppress
from itertools import chain
from pathlib import Path
from typing import Any, TextIO

from pirate_sm.errors import RecordingError
from pirate_sm.loading.file_names import shown
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.recording.format.samples import Placed
from pirate_sm.recording.read.places import recorded_places
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.replay.replay import rerun
from pirate_sm.recording.tables.table_rows import TIME, TableRow, rows_of


def write_tables(recording: Recording, loaded: LoadedMission, folder: Path) -> tuple[Path, ...]:
    """Write each topic of the recording to a CSV file in the folder, and return the files.

    Signals are those that the engine computed from the raw values, one line for each frame.
    Positions of wheels are those shown to viewers: the simulator's true ones, if it knew them.

    Raises:
        RecordingError: The recording is damaged or empty, or the folder cannot be written. No
            tables are left then.
    """
    tables: _Tables | None = None
    try:
        with ExitStack() as stack:
            tables = _Tables(loaded, folder, stack)
            _fill(tables, recording, loaded)
    except (OSError, RecordingError) as error:
        if tables is not None:
            tables.discard()
        if isinstance(error, RecordingError):
            raise
        raise RecordingError(f"{folder} cannot be written: {error.strerror}") from None
    if not tables.files:
        raise RecordingError(f"{shown(recording.path)} has no data for tables")
    return tables.files


def _fill(tables: _Tables, recording: Recording, loaded: LoadedMission) -> None:
    again = rerun(recording, loaded, every_signal=True)
    for row in rows_of(loaded.robot, again, recording.origin_s):
        tables.add(row)
    for placed in recorded_places(recording, loaded.loaded_robot.profile.body):
        tables.places(placed)


class _Tables:
    """The files being written; each begins with its first line."""

    def __init__(self, loaded: LoadedMission, folder: Path, stack: ExitStack) -> None:
        self._wheels = loaded.loaded_robot.profile.body.wheels
        self._parts = loaded.robot.parts
        self._folder = folder
        self._stack = stack
        self._writers: dict[str, Any] = {}
        self._paths: list[Path] = []

    @property
    def files(self) -> tuple[Path, ...]:
        return tuple(self._paths)

    def discard(self) -> None:
        """Remove the files, and their folder if it is empty then."""
        with suppress(OSError):
            for path in self._paths:
                path.unlink()
            self._folder.rmdir()

    def places(self, it: Placed) -> None:
        """Add the position of each wheel; ``known`` is 1 if a simulator knew the true one.

        A robot in space has the third coordinate of each wheel besides, the angle of its roll
        joint and the roll of each part.
        """
        columns = [f"{wheel.name}_{axis}_m" for wheel in self._wheels for axis in "xy"]
        places = [*chain.from_iterable(it.wheels)]
        if it.space is not None:
            columns += [f"{wheel.name}_z_m" for wheel in self._wheels]
            columns += [f"roll_{name}_rad" for name in ("joint", *self._parts)]
            places += [*it.space.z_m, *it.space.rolls_rad]
        row = (it.at_s, int(it.known), *map(_shortest, places))
        self.add(TableRow("places", (TIME, "known", *columns), row))

    def add(self, row: TableRow) -> None:
        """Write the row to the file of its table, which begins with its header."""
        writer = self._writers.get(row.table)
        if writer is None:
            self._folder.mkdir(parents=True, exist_ok=True)
            path = self._folder / f"{row.table}.csv"
            file: TextIO = self._stack.enter_context(path.open("w", encoding="utf-8", newline=""))
            writer = self._writers[row.table] = csv.writer(file)
            self._paths.append(path)
            writer.writerow(row.header)
        writer.writerow([_cell(value) for value in row.values])


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
