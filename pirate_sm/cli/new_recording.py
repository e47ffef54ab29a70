"""The file that a run is recorded into: its name, and its beginning."""

from __future__ import annotations

import os
from contextlib import suppress
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say
from pirate_sm.errors import RecordingError
from pirate_sm.loading.folders import shown

if TYPE_CHECKING:
    from pirate_sm.recording.format.header import RunHeader
    from pirate_sm.recording.write.recording_file import RecordingFile, Sink
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
    try:
        return _open(path, header, anew=not asked)
    except FileExistsError:
        raise RecordingError(f"{shown(path)} exists already; nothing has moved") from None
    except OSError as error:
        problem = f"{shown(path)} cannot be written: {error.strerror}"
        if asked:
            raise RecordingError(f"{problem}; nothing has moved") from None
        say(f"warning: nothing is recorded: {problem}")
        return None, path


def _open(path: Path, header: RunHeader, *, anew: bool) -> tuple[RecordingFile, Path]:
    """Make a file that was not there before; ``anew``: under the next free name."""
    from pirate_sm.recording.write.recording_file import DiskFile

    sink: Sink
    for number in count(2):
        try:
            sink = DiskFile(path)
        except FileExistsError:
            if not anew:
                raise
            path = path.with_stem(f"{path.stem.partition('~')[0]}~{number}")
        else:
            return _headed(sink, path, header), path
    raise AssertionError("numbers do not end")


def _headed(sink: Sink, path: Path, header: RunHeader) -> RecordingFile:
    """Write the beginning of a recording; where that fails no file is left."""
    from pirate_sm.recording.write.recording_file import RecordingFile

    try:
        return RecordingFile(sink, header)
    except BaseException:
        with suppress(OSError):
            sink.close()
        with suppress(OSError):
            path.unlink()
        raise
