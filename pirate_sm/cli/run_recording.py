"""Records a run while it goes on, and says what became of the recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say
from pirate_sm.cli.new_recording import begin_recording, usual_path
from pirate_sm.errors import UsageError
from pirate_sm.loading.folders import shown
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import Event
from pirate_sm.wiring.recorded import run_header, shown_to_viewers

if TYPE_CHECKING:
    from pirate_sm.companion import Companion
    from pirate_sm.engine.state import EngineState
    from pirate_sm.recording.format.header import RunHeader
    from pirate_sm.recording.write.recorder import Recorder
    from pirate_sm.recording.write.recording_file import RecordingFile
    from pirate_sm.recording.write.side_channel import SideChannel
    from pirate_sm.runtime.loop import MissionRun
    from pirate_sm.wiring import Prepared

_LIVE_S = 0.1
"""So often viewers that look on get something new."""


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
        """Leave no recording: nothing was asked for in the run."""
        self.wanted = False

    def follow(self, run: MissionRun) -> None:
        """Show this run to viewers, and record its state now and then."""
        if self.tap is not None:
            self.tap.follow(lambda: run.state)
        if self.side is not None:
            self.side.follow(lambda: shown_to_viewers(self.prepared, run.state))


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
        side, served = _side(prepared, options, stack)
        file: RecordingFile | None = None
        if path is not None:
            file, path = begin_recording(path, header, asked=options.record is not None)
        if file is None and not options.live:
            yield Kept(prepared)
            return
        place = path if file else None
        said = (f"recording: {shown(place)}",) if place else ()
        recorder = _recorder(prepared, file, header, side, live=options.live)
        warner = Warner(recorder)
        notices = (*prepared.notices, *served, *said)
        kept = Kept(replace(prepared, notices=notices), recorder, (warner,), side)
        try:
            yield kept
        finally:
            recorder.close()
            if place is not None and not (recorder.begun and kept.wanted):
                with suppress(OSError):
                    place.unlink()  # the run was refused, or it was not asked for anything
            if recorder.failure and (quiet or warner.told != until_when(recorder)):
                say(f"warning: {shown(place) if place else 'live'}: {until_when(recorder)}")
            if side.failure:
                say(f"warning: viewers see less than there is: {side.failure}")


def _recorder(
    prepared: Prepared,
    file: RecordingFile | None,
    header: RunHeader,
    side: SideChannel,
    *,
    live: bool,
) -> Recorder:
    """Return who records into the file, without one only for viewers that look on."""
    from pirate_sm.recording.write.recorder import COMMIT_S, Recorder
    from pirate_sm.recording.write.recording_file import Nowhere, RecordingFile

    return Recorder(
        file or RecordingFile(Nowhere(), header),
        header,
        real_time=prepared.backend.real_time,
        side=side,
        commit_s=_LIVE_S if live else COMMIT_S,
    )


def _side(
    prepared: Prepared, options: RecordingOptions, stack: ExitStack
) -> tuple[SideChannel, tuple[str, ...]]:
    """Return the channel to viewers, and notices about it."""
    from pirate_sm.recording.viewers.viewer_messages import ViewerMessages
    from pirate_sm.recording.write.side_channel import SideChannel

    viewer = ViewerMessages(prepared.loaded, prepared.order.start_at_m)
    if not options.live:
        return SideChannel(viewer), ()
    from pirate_sm.recording.viewers.live_server import Live

    live = Live()
    stack.callback(live.close)
    return SideChannel(viewer, live), (f"live: open {live.address} in Foxglove or Lichtblick",)


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
