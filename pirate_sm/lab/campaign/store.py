"""The results of a campaign in a folder: Parquet files that are only ever added, readable always.

A file is written under another name, synchronised and renamed, so it is whole or not there. As soon
as there are 64 files of one level they are merged into one of the next, unless that would be large:
it is there before they are deleted. What is in two files counts once. A file that is damaged is
named and kept, and its runs are repeated.
"""

from __future__ import annotations

import fcntl
import json
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from io import BytesIO
from itertools import repeat
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, TextIO, get_type_hints

from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import PART, is_file, opened, replace_file
from pirate_sm.lab.campaign.chunk import RunRow

if TYPE_CHECKING:
    from pyarrow import RecordBatch
    from pyarrow import Table as ArrowTable

MARK = "campaign.json"
"""The file that makes a folder a store of results; it has what a reader needs of the campaign."""

_RESULTS, _LOCK, RECORDINGS = "results", "lock", "recordings"

_DAMAGED = ".damaged"
"""Ending of a file that was damaged, once its runs are to be repeated."""

_FLUSH_S = 2.0
"""At most so much work is lost when the client is killed."""

_MOST_ROWS = 20_000
_MOST_FILES = 64
_MOST_MERGED_BYTES = 100_000_000
"""More is not merged: all of it would be in memory, which must not grow with a campaign."""

_TYPES = {str: "string", int: "int64", float: "float64", bool: "bool_"}

_PLAIN = tuple(name for name in RunRow._fields if name != "drawn")
"""The fields of a row that are a column of their own; earlier files lack those with a default."""

_DRAWN = "drawn_"
"""Begins the names of columns of what a run has drawn."""


def is_store(place: Path) -> bool:
    """Return whether there is a store of results at this path."""
    return is_file(place / MARK)


class DamagedMarkError(UsageError):
    """Raised if the file that describes a campaign is damaged; its results may be whole.

    Attributes:
        problem: The message without what to do.
        campaign: Name of the campaign, if it can be read.
    """

    def __init__(self, folder: Path, why: str, campaign: object = None) -> None:
        self.campaign = campaign if isinstance(campaign, str) else None
        self.problem = f"'{folder / MARK}' is damaged ({why})"
        super().__init__(
            f"{self.problem}: the campaign's command with --resume and "
            f"--output {shlex.quote(str(folder))} rewrites it, and keeps the results"
        )


class Store:
    """The results of a campaign in a folder.

    Args:
        folder: The folder.
        clock: The wall clock, s.

    Attributes:
        damaged: The files of results that could not be read so far, and why.
    """

    def __init__(self, folder: Path, clock: Callable[[], float] = monotonic) -> None:
        self.folder = folder
        self._clock = clock
        self._rows: list[RunRow] = []
        self._due_s = clock() + _FLUSH_S
        self._numbers: dict[int, int] = {}
        self._values: dict[str, dict[str, str]] = {}
        self._lock: TextIO | None = None
        self.damaged: dict[Path, str] = {}

    @property
    def recordings(self) -> Path:
        """The folder for recordings of runs that failed."""
        return self.folder / RECORDINGS

    def begin(self, mark: dict[str, Any]) -> None:
        """Make the folder and describe the campaign in it.

        Raises:
            UsageError: It cannot be written.
        """
        with _writing(self.folder):
            (self.folder / _RESULTS).mkdir(parents=True, exist_ok=True)
            self._keep_others_out()
            self._values = {cell["key"]: cell["values"] for cell in mark.get("cells", ())}
            for left in (self.folder / _RESULTS).glob(f"*{PART}"):
                left.unlink()
            replace_file(self.folder / MARK, f"{json.dumps(mark, indent=1)}\n".encode())

    def describe(self, cell: str, values: Mapping[str, str]) -> None:
        """Take what the runs of a further cell have in common, for its rows."""
        self._values[cell] = dict(values)

    def keep(self, name: str, recording: bytes) -> None:
        """Write the recording of a run.

        Raises:
            UsageError: It cannot be written.
        """
        with _writing(self.recordings):
            self.recordings.mkdir(exist_ok=True)
            replace_file(self.recordings / name, recording)

    def _keep_others_out(self) -> None:
        """Lock the folder for this process; the lock ends with the process, however that ends.

        Raises:
            UsageError: Another process has it.
        """
        self._lock = (self.folder / _LOCK).open("w", encoding="utf-8")
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._lock.close()
            raise UsageError(f"another process writes to '{self.folder}' now") from None

    def close(self) -> None:
        """Write what is left, and let others use the folder.

        Raises:
            UsageError: It cannot be written.
        """
        try:
            self.flush()
        finally:
            if self._lock is not None:
                self._lock.close()

    def mark(self) -> dict[str, Any]:
        """Return what :meth:`begin` has written.

        Raises:
            UsageError: There are no results of a campaign here.
            DamagedMarkError: What was written is damaged.
        """
        try:
            with opened(self.folder / MARK) as file:
                found = json.load(file)
        except (FileNotFoundError, NotADirectoryError):
            raise UsageError(f"there are no results of a campaign in '{self.folder}'") from None
        except OSError as error:
            why = error.strerror or str(error)
            raise UsageError(f"'{self.folder / MARK}' cannot be read: {why}") from None
        except (ValueError, RecursionError) as error:
            raise DamagedMarkError(self.folder, f"it is not JSON ({error})") from None
        if not isinstance(found, dict):
            raise DamagedMarkError(self.folder, "it describes no campaign")
        return found

    def read(self) -> Iterator[list[RunRow]]:
        """Yield the rows of each file in the order in which they were written, some at a time.

        Files that cannot be read are in :attr:`damaged` then.
        """
        for file in self._files():
            try:
                for _ in _batches_in(file):  # no row counts of a file with a damaged end
                    pass
                for batch in _batches_in(file):
                    yield _rows_in(batch)
            except _DamagedError as error:
                self.damaged[file] = str(error)

    def set_aside(self) -> None:
        """Rename the files that are damaged, as their runs are to be repeated.

        Raises:
            UsageError: They cannot be renamed.
        """
        with _writing(self.folder / _RESULTS):
            for file in self.damaged:
                file.replace(file.with_name(file.name + _DAMAGED))
        self.damaged.clear()

    def add(self, rows: Sequence[RunRow]) -> None:
        """Add rows; every two seconds they are written to a file.

        Raises:
            UsageError: The file cannot be written; all before it are kept.
        """
        self._rows += rows
        if self._clock() >= self._due_s or len(self._rows) >= _MOST_ROWS:
            self.flush()

    def flush(self) -> None:
        """Write the rows that have been added since the last time.

        Raises:
            UsageError: The file cannot be written; all before it are kept.
        """
        self._due_s = self._clock() + _FLUSH_S
        if self._rows:
            rows, self._rows = self._rows, []
            self._write(_table(rows, self._values), level=0)

    def _merge(self, level: int) -> None:
        """Merge all files of a level into one of the next, unless that is too large."""
        import pyarrow

        files = self._files(level)
        if sum(file.stat().st_size for file in files) > _MOST_MERGED_BYTES:
            return
        whole = {}
        for file in files:
            try:
                whole[file] = pyarrow.Table.from_batches(_batches_in(file))
            except _DamagedError as error:
                self.damaged[file] = str(error)
        if whole:  # they may have different columns
            merged = pyarrow.concat_tables(whole.values(), promote_options="default")
            self._write(merged, level + 1)
        for file in whole:
            with suppress(OSError):
                file.unlink()

    def _files(self, level: int | None = None) -> list[Path]:
        """Return the files of a level, or all of them; the oldest, which are merged, come first."""
        which = "*" if level is None else level
        found = (self.folder / _RESULTS).glob(f"{which}-*.parquet")
        return sorted(found, key=lambda file: (-int(file.stem.partition("-")[0]), file.stem))

    def _write(self, table: ArrowTable, level: int) -> None:
        from pyarrow import parquet

        folder, files = self.folder / _RESULTS, self._files(level)
        # A number that was used is not used again, even if its file is merged already.
        self._numbers[level] = 1 + max(
            [self._numbers.get(level, 0), *(int(file.stem.partition("-")[2]) for file in files)]
        )
        name = f"{level}-{self._numbers[level]:08d}.parquet"
        content = BytesIO()
        parquet.write_table(
            table,
            content,
            row_group_size=_MOST_ROWS,
            compression="zstd",
            write_page_checksum=True,
        )
        with _writing(folder):
            replace_file(folder / name, content.getbuffer())
        if len(files) + 1 >= _MOST_FILES:
            self._merge(level)


@contextmanager
def _writing(folder: Path) -> Iterator[None]:
    """Turn an error of the file system into a message that says what to do."""
    try:
        yield
    except OSError as error:
        why = error.strerror or str(error)
        raise UsageError(
            f"results cannot be written to '{folder}': {why}; what was written before is "
            "kept: once they can be written again, continue with --resume"
        ) from None


def _table(rows: Sequence[RunRow], values: Mapping[str, Mapping[str, str]]) -> ArrowTable:
    """Return rows as a table: their fields, what they have drawn, and the values of their cells."""
    import pyarrow

    kinds = get_type_hints(RunRow)
    columns = {name: (kinds[name], [getattr(row, name) for row in rows]) for name in _PLAIN}
    for name in dict.fromkeys(name for row in rows for name in row.drawn):
        columns[_DRAWN + name] = float, [row.drawn.get(name) for row in rows]
    cells = [values.get(row.cell, {}) for row in rows]
    for name in dict.fromkeys(name for cell in cells for name in cell):
        columns[name] = str, [cell.get(name) for cell in cells]
    return pyarrow.table(
        {
            name: pyarrow.array(column, getattr(pyarrow, _TYPES[kind])())
            for name, (kind, column) in columns.items()
        }
    )


class _DamagedError(Exception):
    """Raised for a file of results that cannot be read; its text says why."""


def _batches_in(file: Path) -> Iterator[RecordBatch]:
    """Yield the rows in a file, some at a time.

    Raises:
        _DamagedError: It cannot be read.
    """
    import pyarrow
    from pyarrow import parquet

    try:
        with (
            opened(file) as stream,
            parquet.ParquetFile(stream, page_checksum_verification=True) as rows,
        ):
            if missing := sorted(
                {*_PLAIN} - {*rows.schema_arrow.names} - RunRow._field_defaults.keys()
            ):
                raise _DamagedError(
                    f"its columns are those of another version: {', '.join(missing)} is not there"
                )
            # `iter_batches` ends early at a damaged page, and says nothing.
            for group in range(rows.num_row_groups):
                yield from rows.read_row_group(group).to_batches(max_chunksize=_MOST_ROWS)
    except (OSError, ValueError, pyarrow.ArrowException) as error:
        why = (getattr(error, "strerror", None) or str(error)).partition("\n")[0]
        raise _DamagedError(why) from None


def _rows_in(batch: RecordBatch) -> list[RunRow]:
    """Return the rows of a batch; what they have drawn is unknown in older ones."""
    names = [name for name in batch.schema.names if name.startswith(_DRAWN)]
    keys = [name.removeprefix(_DRAWN) for name in names]
    columns: dict[str, Iterable[Any]] = {
        name: batch.column(name).to_pylist() if name in batch.schema.names else repeat(usual)
        for name, usual in ((each, RunRow._field_defaults.get(each)) for each in _PLAIN)
    }
    values = zip(*(batch.column(name).to_pylist() for name in names), strict=True)
    columns["drawn"] = [
        {key: value for key, value in zip(keys, row, strict=True) if value is not None}
        for row in (values if names else repeat((), batch.num_rows))
    ]
    ordered = (columns[name] for name in RunRow._fields)
    return [*map(RunRow._make, zip(*ordered, strict=False))]
