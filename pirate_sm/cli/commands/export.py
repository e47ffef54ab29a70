"""`pirate export`: writes a recording as tables and bags, its robot as a URDF, layouts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

from pirate_sm.cli.commands.replay import opened_recording, print_visible
from pirate_sm.cli.options.recordings import ExportOptions
from pirate_sm.cli.output.files import first_line, refuse_losses, write_file
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.on_disk import is_there, take_place
from pirate_sm.running.recording.csv_files import write_tables
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.viewers import layouts
from pirate_sm.running.recording.viewers.complete_recording import write_complete
from pirate_sm.running.recording.viewers.urdf import urdf

Writer: TypeAlias = Callable[[Recording, LoadedMission, Path], None]
"""Writes a recording to a place that is new."""


TableWriter: TypeAlias = Callable[[Recording, LoadedMission, Path], Iterable[Path]]
"""Writes a recording as tables into a folder, and returns the files."""


def run_export(options: ExportOptions) -> int:
    """Write a recording's tables, its robot's URDF, layouts, and all for viewers, as asked.

    Raises:
        RecordingError: The recording cannot be read.
        UsageError: Nothing was requested, a file cannot be written, or it would overwrite a
            recording, another output or somebody's work.
    """
    asked = (
        *(options.csv, options.parquet, options.viewers, options.ros2),
        *(options.urdf, options.lichtblick, options.plotjuggler),
    )
    places = [place for place in asked if place is not None]
    if not places:
        raise UsageError(
            "say what to export: --csv, --parquet DIR, --viewers OUT.mcap, --ros2 DIR, --urdf, "
            "--lichtblick, --plotjuggler FILE"
        )
    if "" in places:
        raise UsageError("a folder or a file has a name: '' is none")
    # Bags and recordings of viewers have to be new, what writes them says so; tables are looked at
    # when their headers are known.
    refuse_losses(map(Path, places), inputs=[Path(options.recording)], overwrite=True)
    texts = filter(None, (options.urdf, options.lichtblick, options.plotjuggler))
    refuse_losses(map(Path, texts), overwrite=options.overwrite)
    tables, writers = list(_table_writers(options)), list(_writers(options))
    recorded = opened_recording(options.recording)
    with recorded as recording, recorded_mission(recording.header) as loaded:
        written = _write_tables(tables, recording, loaded, overwrite=options.overwrite)
        for place, write in writers:
            _write_new(write, recording, loaded, Path(place))
            written.append(place)
        for place, text in _texts(loaded, options):
            write_file(Path(place), text)
            written.append(place)
    for file in written:
        print_visible(file)
    return 0


def _table_writers(options: ExportOptions) -> Iterator[tuple[str, TableWriter]]:
    """Yield each requested folder of tables with the function that writes it.

    Raises:
        UsageError: A package that it needs is not installed.
    """
    if options.csv is not None:
        yield options.csv, write_tables
    if options.parquet is not None:
        from pirate_sm.running.recording.parquet_files import write_parquet

        yield options.parquet, write_parquet


def _writers(options: ExportOptions) -> Iterator[tuple[str, Writer]]:
    """Yield each requested recording or bag with the function that writes it.

    Raises:
        UsageError: A package that it needs is not installed.
    """
    if options.viewers is not None:
        yield options.viewers, write_complete
    if options.ros2 is not None:
        from pirate_sm.running.recording.viewers.ros2_bag import write_bag

        yield options.ros2, write_bag


def _write_tables(
    writers: Iterable[tuple[str, TableWriter]],
    recording: Recording,
    loaded: LoadedMission,
    *,
    overwrite: bool,
) -> list[str]:
    """Write the tables and return their files: all of them, or nothing if one may not be written.

    Raises:
        RecordingError: The recording is damaged or empty.
        UsageError: A folder cannot be written, or a table would overwrite somebody's work.
    """
    parts: dict[Path, Path] = {}
    with ExitStack() as stack:
        for folder, write in writers:
            with _said_of(Path(folder)):
                part = stack.enter_context(_new_folder_in(Path(folder)))
                parts |= {Path(folder, each.name): each for each in write(recording, loaded, part)}
        tables = map(first_line, parts.values())
        refuse_losses(parts, tables=tables, overwrite=overwrite)
        for place, part in parts.items():
            with _said_of(place):
                take_place(part, place.resolve())
    return list(map(str, parts))


@contextmanager
def _new_folder_in(folder: Path) -> Iterator[Path]:
    """Make a folder in a folder, and that if it is not there; leave neither if they are empty."""
    made = not is_there(folder)
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with TemporaryDirectory(prefix=".tables-", dir=folder) as inside:
            yield Path(inside)
    finally:
        if made:
            with suppress(OSError):
                folder.rmdir()


def _write_new(write: Writer, recording: Recording, loaded: LoadedMission, place: Path) -> None:
    with _said_of(place):
        try:
            write(recording, loaded, place)
        except FileExistsError:
            raise UsageError(f"{shown(place)} exists already; nothing is written there") from None


@contextmanager
def _said_of(place: Path) -> Iterator[None]:
    """Say of an error of the disk which place cannot be written.

    Raises:
        UsageError: There is such an error.
    """
    try:
        yield
    except OSError as error:
        why = error.strerror or error
        raise UsageError(f"{shown(place)} cannot be written: {why}") from None


def _texts(loaded: LoadedMission, options: ExportOptions) -> Iterator[tuple[str, str]]:
    """Yield each requested file with its text."""
    if options.urdf is not None:
        yield options.urdf, urdf(loaded.loaded_robot.profile)
    if options.lichtblick is not None:
        yield options.lichtblick, layouts.lichtblick_layout(loaded)
    if options.plotjuggler is not None:
        yield options.plotjuggler, layouts.plotjuggler_layout(loaded)
