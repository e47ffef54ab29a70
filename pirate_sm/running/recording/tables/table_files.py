"""A recording as tables in a folder, one file for each, whatever their format."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from itertools import chain
from pathlib import Path
from typing import Protocol

from pirate_sm.core.errors import RecordingError
from pirate_sm.core.files import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.format.samples import Placed
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.replay.replay import rerun
from pirate_sm.running.recording.tables.table_rows import KNOWN, PLACES, TIME, TableRow, rows_of


class TableFile(Protocol):
    """A table that is being written to its file."""

    def add(self, row: TableRow) -> None:
        """Add a row."""

    def close(self) -> None:
        """Complete the file."""


def write_files(
    recording: Recording,
    loaded: LoadedMission,
    folder: Path,
    suffix: str,
    begin: Callable[[Path, TableRow], TableFile],
) -> tuple[Path, ...]:
    """Write each topic of the recording to a file in the folder, and return the files.

    Signals are those that the engine computed from the raw values, one row for each frame.
    Positions of wheels are those shown to viewers: the simulator's true ones, if it knew them.

    Args:
        recording: The recording.
        loaded: Its mission.
        folder: The folder.
        suffix: The end of the files' names.
        begin: Opens the file of a table, given the table's first row.

    Raises:
        OSError: The folder cannot be written.
        RecordingError: The recording is damaged or empty.
    """
    files: dict[str, TableFile] = {}
    paths: list[Path] = []
    with ExitStack() as stack:
        for row in _rows(recording, loaded):
            if row.table not in files:
                folder.mkdir(parents=True, exist_ok=True)
                path = folder / f"{row.table}{suffix}"
                files[row.table] = stack.enter_context(closing(begin(path, row)))
                paths.append(path)
            files[row.table].add(row)
    if not paths:
        raise RecordingError(f"{shown(recording.path)} has no data for tables")
    return tuple(paths)


def _rows(recording: Recording, loaded: LoadedMission) -> Iterator[TableRow]:
    again = rerun(recording, loaded, every_signal=True)
    yield from rows_of(loaded.robot, again, recording.origin_s)
    for placed in recorded_places(recording, loaded.loaded_robot.profile.body):
        yield _place(placed, loaded)


def _place(it: Placed, loaded: LoadedMission) -> TableRow:
    """Return the position of each wheel; ``known`` is 1 if a simulator knew the true one.

    A robot in space has the third coordinate of each wheel besides, the angle of its roll joint
    and the roll of each part.
    """
    wheels = loaded.loaded_robot.profile.body.wheels
    columns = [f"{wheel.name}_{axis}_m" for wheel in wheels for axis in "xy"]
    places = [*chain.from_iterable(it.wheels)]
    if it.space is not None:
        columns += [f"{wheel.name}_z_m" for wheel in wheels]
        columns += [f"roll_{name}_rad" for name in ("joint", *loaded.robot.parts)]
        places += [*it.space.z_m, *it.space.rolls_rad]
    return TableRow(PLACES, (TIME, KNOWN, *columns), (it.at_s, int(it.known), *places))
