"""`pirate export`: writes a recording as tables and bags, its robot as a URDF, layouts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TypeAlias

from pirate_sm.cli.opened_recording import opened_recording, print_visible
from pirate_sm.cli.options.recordings import ExportOptions
from pirate_sm.cli.output.files import refuse_losses, write_file
from pirate_sm.errors import UsageError
from pirate_sm.loading.file_names import shown
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.recording.read.reader import Recording
from pirate_sm.recording.replay.recorded_mission import recorded_mission
from pirate_sm.recording.tables.csv_files import write_tables
from pirate_sm.recording.viewers import layouts
from pirate_sm.recording.viewers.complete_recording import write_complete
from pirate_sm.recording.viewers.urdf import urdf

Writer: TypeAlias = Callable[[Recording, LoadedMission, Path], Iterable[str]]
"""Writes a recording to a place, and returns the files."""


def run_export(options: ExportOptions) -> int:
    """Write a recording's tables, its robot's URDF, layouts, and all for viewers, as asked.

    Raises:
        RecordingError: The recording cannot be read, or a folder cannot be written.
        UsageError: Nothing was requested, a file cannot be written, or it would overwrite a
            recording or another output.
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
    # Folders and recordings of viewers have to be new: what writes them says so.
    refuse_losses(map(Path, places), inputs=[Path(options.recording)], overwrite=True)
    texts = filter(None, (options.urdf, options.lichtblick, options.plotjuggler))
    refuse_losses(map(Path, texts), overwrite=options.overwrite)
    writers = dict(_writers(options))
    written: list[str] = []
    recorded = opened_recording(options.recording)
    with recorded as recording, recorded_mission(recording.header) as loaded:
        for place, write in writers.items():
            written += write(recording, loaded, Path(place))
        for place, text in _texts(loaded, options):
            write_file(Path(place), text)
            written.append(place)
    for file in written:
        print_visible(file)
    return 0


def _writers(options: ExportOptions) -> Iterator[tuple[str, Writer]]:
    """Yield each requested folder or recording with the function that writes it.

    Raises:
        UsageError: A package that it needs is not installed.
    """
    if options.csv is not None:
        yield options.csv, partial(_tables, write_tables)
    if options.parquet is not None:
        from pirate_sm.recording.tables.parquet_files import write_parquet

        yield options.parquet, partial(_tables, write_parquet)
    if options.viewers is not None:
        yield options.viewers, partial(_new, write_complete)
    if options.ros2 is not None:
        from pirate_sm.recording.viewers.ros2_bag import write_bag

        yield options.ros2, partial(_new, write_bag)


def _tables(
    write: Callable[[Recording, LoadedMission, Path], Iterable[Path]],
    recording: Recording,
    loaded: LoadedMission,
    folder: Path,
) -> Iterable[str]:
    return map(str, write(recording, loaded, folder))


def _new(
    write: Callable[[Recording, LoadedMission, Path], None],
    recording: Recording,
    loaded: LoadedMission,
    path: Path,
) -> Iterable[str]:
    try:
        write(recording, loaded, path)
    except FileExistsError:
        raise UsageError(f"{shown(path)} exists already; nothing is written there") from None
    except OSError as error:
        raise UsageError(f"{shown(path)} cannot be written: {error.strerror}") from None
    return [str(path)]


def _texts(loaded: LoadedMission, options: ExportOptions) -> Iterator[tuple[str, str]]:
    """Yield each requested file with its text."""
    if options.urdf is not None:
        yield options.urdf, urdf(loaded.loaded_robot.profile)
    if options.lichtblick is not None:
        yield options.lichtblick, layouts.lichtblick_layout(loaded)
    if options.plotjuggler is not None:
        yield options.plotjuggler, layouts.plotjuggler_layout(loaded)
