"""A recording as Parquet files, whose columns carry their SI units."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any, Final

from pirate_sm import __version__
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.signal_names import signal_units
from pirate_sm.running.recording.tables import KNOWN, SIGNALS, TableRow, write_files

try:
    import pyarrow
    from pyarrow import parquet
except ModuleNotFoundError:
    raise UsageError(
        "tables in Parquet need pyarrow, which is not installed: pip install 'pirate-sm[parquet]'"
    ) from None

UNIT: Final = b"unit"
"""The key of a column's unit in its metadata."""

_ROWS: Final = 20_000
"""Rows of a row group: so many are in memory at a time."""

_WHOLE: Final = frozenset({"setpoint_id", KNOWN})
"""Columns of whole numbers; the other numbers may have a fraction or be unknown."""

_UNITS: Final = {"_s": "s", "_m": "m", "_rad": "rad"}
"""Units by how the name of a column ends, except for signals, whose names end in anything."""


def write_parquet(recording: Recording, loaded: LoadedMission, folder: Path) -> tuple[Path, ...]:
    """Write each topic of the recording to a Parquet file in the folder, and return the files.

    The metadata of a column have its unit, those of a file this program, the mission, the robot and
    the run's beginning.

    Raises:
        OSError: The folder cannot be written.
        RecordingError: The recording is damaged or empty.
    """
    header = recording.header
    about = {"mission": header.mission, "robot": header.robot, "began": header.began}
    about |= {"program": f"pirate-sm {__version__}"}
    begin = partial(_ParquetFile, about=about, units=signal_units(loaded.robot))
    return write_files(recording, loaded, folder, ".parquet", begin)


class _ParquetFile:
    """A table as Parquet, compressed by Zstandard.

    Args:
        path: The file.
        first: The first row, which shows what is text and what a number.
        about: What the file's metadata say.
        units: The units of signals by column.
    """

    def __init__(
        self, path: Path, first: TableRow, about: dict[str, str], units: dict[str, str]
    ) -> None:
        fields = [
            pyarrow.field(name, pyarrow.string())
            if isinstance(value, str)
            else pyarrow.field(name, _kind(name), metadata=_unit(name, first.table, units))
            for name, value in zip(first.header, first.values, strict=True)
        ]
        self._schema = pyarrow.schema(fields, metadata=about)
        self._writer = parquet.ParquetWriter(path, self._schema, compression="zstd")
        self._rows: list[tuple[Any, ...]] = []

    def add(self, row: TableRow) -> None:
        self._rows.append(row.values)
        if len(self._rows) >= _ROWS:
            self._write()

    def close(self) -> None:
        try:
            self._write()
        finally:
            self._writer.close()

    def _write(self) -> None:
        if not self._rows:
            return
        columns = [
            pyarrow.array(values, field.type)
            for values, field in zip(zip(*self._rows, strict=True), self._schema, strict=True)
        ]
        self._writer.write_table(pyarrow.Table.from_arrays(columns, schema=self._schema))
        self._rows.clear()


def _kind(name: str) -> pyarrow.DataType:
    return pyarrow.int64() if name in _WHOLE else pyarrow.float64()


def _unit(name: str, table: str, units: dict[str, str]) -> dict[bytes, bytes] | None:
    if table == SIGNALS and name in units:
        unit = units[name]
    else:
        unit = next((unit for end, unit in _UNITS.items() if name.endswith(end)), "")
    return {UNIT: unit.encode()} if unit else None
