"""The recording of a run: where it goes, what is said of it, how it ends."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import count
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.guard import say
from pirate_sm.errors import RecordingError, UsageError
from pirate_sm.loading.folders import shown
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import Event
from pirate_sm.wiring.recorded import run_header, shown_to_viewers

if TYPE_CHECKING:
    from pirate_sm.companion import Companion
    from pirate_sm.engine.state import EngineState
    from pirate_sm.recording.file import RecordingFile, Sink
    from pirate_sm.recording.header import RunHeader
    from pirate_sm.recording.recorder import Recorder
    from pirate_sm.recording.side_channel import SideChannel
    from pirate_sm.runtime.loop import MissionRun
    from pirate_sm.wiring import Prepared

RUNS = "runs"
RUNS_VARIABLE = "PIRATE_SM_RUNS"
"""Names the folder for recordings in place of ``runs``; empty: none unless asked for."""

_LIVE_S = 0.1
"""So often viewers that look on get something new."""


@dataclass(frozen=True)
class RecordingWishes:
    """What the command line says of recording.

    Attributes:
        record: The file; None for one of the usual name.
        off: Whether nothing is to be kept.
        live: Whether viewers are served while the run goes on.
    """

    record: str | None = None
    off: bool = False
    live: bool = False


@dataclass
class Kept:
    """A run that is being recorded, or not.

    Attributes:
        prepared: The run, with what is to be said of its recording.
        tap: Who keeps it; None where nobody does.
        companions: Who stands beside the mission for it.
        wanted: Whether the recording is to be left when the run is over.
    """

    prepared: Prepared
    tap: Recorder | None = None
    companions: tuple[Companion, ...] = ()
    side: SideChannel | None = None
    wanted: bool = True

    def forget(self) -> None:
        """No recording is left, for nothing was asked for in the run."""
        self.wanted = False

    def follow(self, run: MissionRun) -> None:
        """Viewers are shown this run, and its state is kept now and then."""
        if self.tap is not None:
            self.tap.follow(lambda: run.state)
        if self.side is not None:
            self.side.follow(lambda: shown_to_viewers(self.prepared, run.state))


@contextmanager
def recorded(
    prepared: Prepared, wishes: RecordingWishes, factor: float, *, quiet: bool = False
) -> Iterator[Kept]:
    """The run is recorded as was wished, until the block ends.

    Args:
        prepared: The run.
        wishes: The wishes.
        factor: Mission seconds per second.
        quiet: Whether the run's output leaves out what the recording tells while it goes on.

    Raises:
        RecordingError: It was to go into a file that cannot be made.
        UsageError: The wishes exclude each other.
    """
    if wishes.record is not None and wishes.off:
        raise UsageError("--record and --no-record exclude each other")
    began = datetime.now(UTC).astimezone()
    path = _path(wishes, prepared, began)
    if path is None and not wishes.live:
        yield Kept(prepared)
        return
    from pirate_sm.recording.file import Nowhere, RecordingFile
    from pirate_sm.recording.recorder import COMMIT_S, Recorder

    header = run_header(prepared, factor, began)
    with ExitStack() as stack:
        side, served = _side(prepared, wishes, stack)
        file: RecordingFile | None = None
        if path is not None:
            file, path = _begun(path, header, asked=wishes.record is not None)
        if file is None and not wishes.live:
            yield Kept(prepared)
            return
        name = shown(path) if file and path else ""
        said = (f"recording: {name}",) if name else ()
        file = file or RecordingFile(Nowhere(), header)
        recorder = Recorder(
            file, header, real_time=prepared.backend.real_time, side=side,
            commit_s=_LIVE_S if wishes.live else COMMIT_S,
        )  # fmt: skip
        warner = Warner(recorder)
        notices = (*prepared.notices, *served, *said)
        kept = Kept(replace(prepared, notices=notices), recorder, (warner,), side)
        try:
            yield kept
        finally:
            recorder.close()
            if path is not None and name and not (recorder.begun and kept.wanted):
                with suppress(OSError):
                    path.unlink()  # the run was refused, or it was not asked for anything
            if recorder.failure and (quiet or warner.told != until_when(recorder)):
                say(f"warning: {name or 'live'}: {until_when(recorder)}")
            if side.failure:
                say(f"warning: viewers see less than there is: {side.failure}")


def _side(
    prepared: Prepared, wishes: RecordingWishes, stack: ExitStack
) -> tuple[SideChannel, tuple[str, ...]]:
    """What viewers are shown, and what is to be said of it."""
    from pirate_sm.recording.side_channel import SideChannel
    from pirate_sm.recording.viewing import Viewer

    viewer = Viewer(prepared.loaded, prepared.order.start_at_m)
    if not wishes.live:
        return SideChannel(viewer), ()
    from pirate_sm.recording.live import Live

    live = Live()
    stack.callback(live.close)
    return SideChannel(viewer, live), (f"live: open {live.address} in Foxglove or Lichtblick",)


def _begun(path: Path, header: RunHeader, *, asked: bool) -> tuple[RecordingFile | None, Path]:
    """The recording with its beginning written, and its path; none where that cannot be.

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


def until_when(recorder: Recorder) -> str:
    """Until when a recording holds that has ended before its run, and why it has."""
    if recorder.kept_s is None:
        return f"nothing of the run is recorded: {recorder.failure}"
    return f"the recording holds until {recorder.kept_s:.3f} s and ends there: {recorder.failure}"


class Warner:
    """A companion that tells once, when the recording has ended before the run."""

    listening = False

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self.told = ""

    @property
    def due_s(self) -> float:
        """At once when there is something to tell."""
        return 0.0 if self._recorder.failure and not self.told else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Nothing is different."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """The warning."""
        self.told = until_when(self._recorder)
        return (Log("warning", f"{self.told}; the run goes on"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Nothing."""
        return ()


def _path(wishes: RecordingWishes, prepared: Prepared, began: datetime) -> Path | None:
    """Where the recording goes; None: nowhere."""
    if wishes.record is not None:
        return Path(wishes.record)
    folder = os.environ.get(RUNS_VARIABLE, RUNS)
    if wishes.off or not folder:
        return None
    name = f"{began:%Y-%m-%dT%H-%M-%S}_{prepared.loaded.mission.mission}_{prepared.order.backend}"
    return Path(folder) / f"{name}.mcap"


def _open(path: Path, header: RunHeader, *, anew: bool) -> tuple[RecordingFile, Path]:
    """A file that was not there before, and its path; ``anew``: of the next free name."""
    from pirate_sm.recording.file import DiskFile

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
    """The recording with its beginning written; where that fails there is no file."""
    from pirate_sm.recording.file import RecordingFile

    try:
        return RecordingFile(sink, header)
    except BaseException:
        with suppress(OSError):
            sink.close()
        with suppress(OSError):
            path.unlink()
        raise
