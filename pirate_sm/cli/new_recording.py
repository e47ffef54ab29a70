"""The file that a run is recorded into: its name, and its beginning."""

from __future__ import annotations

import os
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say
from pirate_sm.loading.file_names import shown
from pirate_sm.wiring.run_recorder import new_recording, requested_recording

if TYPE_CHECKING:
    from pirate_sm.recording.format.header import RunHeader
    from pirate_sm.recording.write.recording_file import RecordingFile
    from pirate_sm.wiring import Prepared

RUNS = "runs"
RUNS_VARIABLE = "PIRATE_SM_RUNS"
"""Names the folder for recordings in place of ``runs``; empty: none unless asked for."""


def usual_path(prepared: Prepared, began: datetime) -> Path | None:
    """Return where a run is recorded that names no file; None where nobody wants it."""
    folder = os.environ.get(RUNS_VARIABLE, RUNS)
    name = f"{began:%Y-%m-%dT%H-%M-%S}_{prepared.loaded.mission.mission}_{prepared.order.backend}"
    return Path(folder) / f"{name}.mcap" if folder else None


def begin_recording(
    path: Path, header: RunHeader, *, asked: bool
) -> tuple[RecordingFile | None, Path]:
    """Make a recording and write its beginning; return it with its path, None where that fails.

    Args:
        path: Where to.
        header: Its beginning.
        asked: Whether the file was asked for, so that there is no run without it, and no other
            name will do.

    Raises:
        RecordingError: It was asked for and cannot be made.
    """
    if asked:
        return requested_recording(path, header), path
    for number in count(2):
        try:
            return new_recording(path, header), path
        except FileExistsError:
            path = path.with_stem(f"{path.stem.partition('~')[0]}~{number}")
        except OSError as error:
            problem = f"{shown(path)} cannot be written: {error.strerror}"
            say(f"warning: nothing is recorded: {problem}")
            return None, path
    raise AssertionError("numbers do not end")
