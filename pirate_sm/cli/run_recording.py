"""Records a run while it goes on, and says what became of the recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say
from pirate_sm.cli.new_recording import begin_recording, usual_path
from pirate_sm.errors import UsageError
from pirate_sm.loading.file_names import shown
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import Event
from pirate_sm.wiring.run_recorder import RunRecorder, run_header

if TYPE_CHECKING:
    from pirate_sm.companion import Companion
    from pirate_sm.engine.state import EngineState
    from pirate_sm.recording.viewers.live_server import Live
    from pirate_sm.recording.write.recorder import Recorder
    from pirate_sm.recording.write.recording_file import RecordingFile
    from pirate_sm.runtime.loop import MissionRun
    from pirate_sm.wiring import Prepared


@dataclass(frozen=True)
class RecordingOptions:
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
        recording: Where to; None: nowhere.
        companions: Who stands beside the mission for it.
        wanted: Whether the recording is to be left when the run is over.
    """

    prepared: Prepared
    recording: RunRecorder | None = None
    companions: tuple[Companion, ...] = ()
    wanted: bool = True

    @property
    def tap(self) -> Recorder | None:
        """Who keeps the run; None where nobody does."""
        return self.recording.recorder if self.recording is not None else None

    def forget(self) -> None:
        """Leave no recording: nothing was asked for in the run."""
        self.wanted = False

    def follow(self, run: MissionRun) -> None:
        """Show this run to viewers, and record its state now and then."""
        if self.recording is not None:
            self.recording.follow(self.prepared, lambda: run.state)


@contextmanager
def recorded(
    prepared: Prepared, options: RecordingOptions, factor: float, *, quiet: bool = False
) -> Iterator[Kept]:
    """Record the run as is asked for, until the block ends.

    Args:
        prepared: The run.
        options: What is to be recorded, and how.
        factor: Mission seconds per second.
        quiet: Whether the run's output leaves out what the recording tells while it goes on.

    Raises:
        RecordingError: It was to go into a file that cannot be made.
        UsageError: The options exclude each other.
    """
    if options.record is not None and options.off:
        raise UsageError("--record and --no-record exclude each other")
    began = datetime.now(UTC).astimezone()
    path = None if options.off else usual_path(prepared, began)
    path = path if options.record is None else Path(options.record)
    if path is None and not options.live:
        yield Kept(prepared)
        return
    header = run_header(prepared, factor, began)
    with ExitStack() as stack:
        live, served = _live(options, stack)
        file: RecordingFile | None = None
        if path is not None:
            file, path = begin_recording(path, header, asked=options.record is not None)
        if file is None and not options.live:
            yield Kept(prepared)
            return
        place = path if file else None
        said = (f"recording: {shown(place)}",) if place else ()
        recording = RunRecorder(prepared, header, file, live)
        recorder, side = recording.recorder, recording.side
        warner = Warner(recorder)
        notices = (*prepared.notices, *served, *said)
        kept = Kept(replace(prepared, notices=notices), recording, (warner,))
        try:
            yield kept
        finally:
            recording.close(place, wanted=kept.wanted)
            if recorder.failure and (quiet or warner.told != until_when(recorder)):
                say(f"warning: {shown(place) if place else 'live'}: {until_when(recorder)}")
            if side.failure:
                say(f"warning: viewers see less than there is: {side.failure}")


def _live(options: RecordingOptions, stack: ExitStack) -> tuple[Live | None, tuple[str, ...]]:
    """Return what serves viewers while the run goes on, and notices about it."""
    if not options.live:
        return None, ()
    from pirate_sm.recording.viewers.live_server import Live

    live = Live()
    stack.callback(live.close)
    return live, (f"live: open {live.address} in Foxglove or Lichtblick",)


def until_when(recorder: Recorder) -> str:
    """Return until when a recording holds that ended before its run, and why it did."""
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
        """At once when there is a warning to give."""
        return 0.0 if self._recorder.failure and not self.told else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return the warning."""
        self.told = until_when(self._recorder)
        return (Log("warning", f"{self.told}; the run goes on"),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return no event."""
        return ()
