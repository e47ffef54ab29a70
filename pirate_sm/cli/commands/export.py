"""`pirate export`: writes a recording as tables, its robot as a URDF, layouts for viewers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

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


def run_export(options: ExportOptions) -> int:
    """Write a recording's tables, its robot's URDF, layouts, and all for viewers, as asked.

    Raises:
        RecordingError: The recording cannot be read, or a folder cannot be written.
        UsageError: Nothing was requested, a file cannot be written, or it would overwrite a
            recording or another output.
    """
    asked = (
        *(options.csv, options.viewers, options.urdf),
        *(options.lichtblick, options.plotjuggler),
    )
    places = [place for place in asked if place is not None]
    if not places:
        raise UsageError(
            "say what to export: --csv DIR, --viewers OUT.mcap, --urdf, --lichtblick, "
            "--plotjuggler FILE"
        )
    if "" in places:
        raise UsageError("a folder or a file has a name: '' is none")
    refuse_losses(map(Path, places))
    written: list[str] = []
    recorded = opened_recording(options.recording)
    with recorded as recording, recorded_mission(recording.header) as loaded:
        if options.csv is not None:
            written += map(str, write_tables(recording, loaded, Path(options.csv)))
        if options.viewers is not None:
            _write_viewers(recording, loaded, Path(options.viewers))
            written.append(options.viewers)
        for place, text in _texts(loaded, options):
            write_file(Path(place), text)
            written.append(place)
    for file in written:
        print_visible(file)
    return 0


def _write_viewers(recording: Recording, loaded: LoadedMission, path: Path) -> None:
    try:
        write_complete(recording, loaded, path)
    except FileExistsError:
        raise UsageError(f"{shown(path)} exists already; nothing is written there") from None
    except OSError as error:
        raise UsageError(f"{shown(path)} cannot be written: {error.strerror}") from None


def _texts(loaded: LoadedMission, options: ExportOptions) -> Iterator[tuple[str, str]]:
    """Yield each requested file with its text."""
    if options.urdf is not None:
        yield options.urdf, urdf(loaded.loaded_robot.profile)
    if options.lichtblick is not None:
        yield options.lichtblick, layouts.lichtblick_layout(loaded)
    if options.plotjuggler is not None:
        yield options.plotjuggler, layouts.plotjuggler_layout(loaded)
