"""The recording of a run: its default path, and its creation."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say
from pirate_sm.cli.settings import runs_folder
from pirate_sm.loading.file_names import shown
from pirate_sm.wiring.run_recorder import new_recording, requested_recording

if TYPE_CHECKING:
    from pirate_sm.recording.format.header import RunHeader
    from pirate_sm.recording.write.recording_file import RecordingFile
    from pirate_sm.wiring import Prepared


def usual_path(prepared: Prepared, began: datetime) -> Path | None:
    """Return the default path of a run's recording; None if there is none by default."""
    folder = runs_folder()
    name = f"{began:%Y-%m-%dT%H-%M-%S}_{prepared.loaded.mission.mission}_{prepared.order.backend}"
    return Path(folder) / f"{name}.mcap" if folder else None


def begin_recording(
    path: Path, header: RunHeader, *, asked: bool
) -> tuple[RecordingFile | None, Path]:
    """Create a recording and write its header; return it with its path, None if that fails.

    Args:
        path: Path of the file.
        header: Its header.
        asked: Whether the user named the file, so that the run needs it and under this very name.

    Raises:
        RecordingError: The user named the file, and it cannot be created.
    """
    if asked:
        return requested_recording(path, header), path
    for number in count(2):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            return new_recording(path, header), path
        except FileExistsError:
            if not path.parent.is_dir():
                say(f"warning: nothing is recorded: {shown(path)}: its folder is a file")
                return None, path
            path = path.with_stem(f"{path.stem.partition('~')[0]}~{number}")
        except OSError as error:
            problem = f"{shown(path)} cannot be written: {error.strerror}"
            say(f"warning: nothing is recorded: {problem}")
            return None, path
    raise AssertionError("numbers do not end")
