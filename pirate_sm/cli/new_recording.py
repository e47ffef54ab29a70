"""The recording of a run: its default path, and its creation."""

from __future__ import annotations

from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.cli.errors import say
from pirate_sm.cli.settings import BUILT_IN, SettingValue, runs, unusable_runs
from pirate_sm.core.files import shown
from pirate_sm.running.wiring.run_recorder import new_recording, requested_recording

if TYPE_CHECKING:
    from pirate_sm.running.recording.format.header import RunHeader
    from pirate_sm.running.recording.write.recording_file import RecordingFile
    from pirate_sm.running.wiring import Prepared


class RecordingPlace(NamedTuple):
    """Where a run is recorded.

    Attributes:
        path: The file.
        runs: The folder as somebody has set it; None: nobody has, or the file itself was named.
        named: Whether the user named the file, so that the run needs it under this very name.
    """

    path: Path
    runs: SettingValue | None = None
    named: bool = False

    @property
    def asked_for(self) -> bool:
        """Whether the user has named the file or its folder, and so relies on the recording."""
        return self.named or self.runs is not None


def usual_place(prepared: Prepared, began: datetime) -> RecordingPlace | None:
    """Return the default place of a run's recording; None if there is none by default."""
    folder = runs()
    if not folder.value:
        return None
    name = f"{began:%Y-%m-%dT%H-%M-%S}_{prepared.loaded.mission.mission}_{prepared.order.backend}"
    path = Path(folder.value) / f"{name}.mcap"
    return RecordingPlace(path, None if folder.source == BUILT_IN else folder)


def begin_recording(place: RecordingPlace, header: RunHeader) -> tuple[RecordingFile | None, Path]:
    """Create a recording and write its header; return it with its path, None if that fails.

    Raises:
        RecordingError: The user named the file, and it cannot be created.
        LoadError: The user has set the folder, and the file cannot be created there.
    """
    path = place.path
    if place.named:
        return requested_recording(path, header), path
    for number in count(2):
        try:
            _make_folder(path.parent)
            return new_recording(path, header), path
        except FileExistsError:
            path = path.with_stem(f"{path.stem.partition('~')[0]}~{number}")
        except OSError as error:
            if place.runs is not None:
                otherwise = "--no-record runs without a recording"
                why = error.strerror or str(error)
                raise unusable_runs(place.runs, why, otherwise) from None
            problem = f"{shown(path)} cannot be written: {error.strerror}"
            say(f"warning: nothing is recorded: {problem}")
            return None, path
    raise AssertionError("numbers do not end")


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError as error:
        raise NotADirectoryError(error.errno, "its folder is a file") from None
