"""Records a run at its default path, and reports problems with the recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import count
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.cli.errors import say
from pirate_sm.cli.settings import BUILT_IN, SettingValue, runs, unusable_runs
from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import Log
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import shown
from pirate_sm.running.wiring.run_recorder import (
    Kept,
    RunRecorder,
    new_recording,
    requested_recording,
    run_header,
)

if TYPE_CHECKING:
    from pirate_sm.core.engine import EngineState
    from pirate_sm.running.recording.format.header import RunHeader
    from pirate_sm.running.recording.viewers.live_server import Live
    from pirate_sm.running.recording.write.recorder import Recorder
    from pirate_sm.running.recording.write.recording_file import RecordingFile
    from pirate_sm.running.wiring import Prepared
    from pirate_sm.views.report.page_process import PageProcess


# --- a new file ---------------------------------------------------------------------------------


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


# --- recording ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class RecordingOptions:
    """The options about recording.

    Attributes:
        record: The file; None for the default name.
        off: Whether nothing is recorded.
        live: Whether viewers are served during the run.
        page: Its page; None: it has none.
    """

    record: str | None = None
    off: bool = False
    live: bool = False
    page: PageProcess | None = None


@contextmanager
def recorded(
    prepared: Prepared, options: RecordingOptions, factor: float, *, quiet: bool = False
) -> Iterator[Kept]:
    """Record the run as the options say, until the block ends.

    Args:
        prepared: The run.
        options: What to record, and how.
        factor: Mission seconds per second.
        quiet: Whether the output omits warnings about the recording during the run.

    Raises:
        RecordingError: The requested file cannot be created.
        LoadError: It cannot be created in the folder that a setting names.
        UsageError: The options exclude each other.
    """
    if options.record is not None and options.off:
        raise UsageError("--record and --no-record exclude each other")
    began = datetime.now(UTC).astimezone()
    where = _place(prepared, options, began)
    if where is None and not options.live:
        yield Kept(prepared)
        return
    header = run_header(prepared, factor, began, live=options.live)
    with ExitStack() as stack:
        live, served = _live(options, stack)
        file: RecordingFile | None = None
        path: Path | None = None
        if where is not None:
            file, path = begin_recording(where, header)
        if file is None and not options.live:
            yield Kept(prepared)
            return
        place = path if file else None
        said = (f"recording: {shown(place)}",) if place else ()
        recording = RunRecorder(prepared, header, file, live, watched=options.page is not None)
        recorder, side = recording.recorder, recording.side
        warner = Warner(recorder)
        kept = Kept(prepared, recording, (warner,))
        try:
            if options.page is not None and place is not None:
                served += (f"page: open {options.page.address} in a browser",)
                earlier = prepared.order.forecast
                forecast = None if earlier is None else Path(earlier)
                kept.companions += (options.page.follow(place, forecast),)
            kept.prepared = replace(prepared, notices=(*prepared.notices, *served, *said))
            yield kept
        finally:
            recording.close(place, wanted=kept.wanted)
            if recorder.failure and (quiet or warner.warning != until_when(recorder)):
                say(f"warning: {shown(place) if place else 'live'}: {until_when(recorder)}")
            if recorder.failure and where is not None and where.asked_for:
                kept.lost = place
            if side.failure:
                say(f"warning: viewers get incomplete data: {side.failure}")


def check_page(prepared: Prepared, options: RecordingOptions) -> None:
    """Check that there is something for a page to show.

    Raises:
        UsageError: Nothing is recorded.
    """
    if _place(prepared, options, datetime.now(UTC)) is None:
        raise UsageError("--page shows what is recorded, and nothing is")


def _place(prepared: Prepared, options: RecordingOptions, began: datetime) -> RecordingPlace | None:
    """Return where the run is recorded; None if it is not."""
    if options.record is not None:
        return RecordingPlace(Path(options.record), named=True)
    return None if options.off else usual_place(prepared, began)


def _live(options: RecordingOptions, stack: ExitStack) -> tuple[Live | None, tuple[str, ...]]:
    """Return the server for viewers, and notices about it."""
    if not options.live:
        return None, ()
    from pirate_sm.running.recording.viewers.live_server import Live

    live = Live()
    stack.callback(live.close)
    return live, (f"live: open {live.address} in Foxglove or Lichtblick",)


def until_when(recorder: Recorder) -> str:
    """Return up to when a recording that ended early goes, and why it ended."""
    if recorder.kept_s is None:
        return f"nothing of the run is recorded: {recorder.failure}"
    return f"the recording holds until {recorder.kept_s:.3f} s and ends there: {recorder.failure}"


class Warner(CompanionBase):
    """A companion that warns once if the recording has ended before the run."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self.warning = ""

    @property
    def due_s(self) -> float:
        """At once if there is a warning; else infinite."""
        return 0.0 if self._recorder.failure and not self.warning else inf

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return the warning."""
        self.warning = until_when(self._recorder)
        return (Log("warning", f"{self.warning}; the run continues"),)
