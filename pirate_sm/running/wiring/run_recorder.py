"""Records a prepared run: the header, the viewers' messages, the recorder with its file.

Samples of the run are taken for viewers, or to keep what its inputs do not give again.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from itertools import chain
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import InSpace, Stood, Trail
from pirate_sm.core.geometry import Place
from pirate_sm.core.library import shown
from pirate_sm.core.visible import visible
from pirate_sm.running.wiring.prepared import Prepared

if TYPE_CHECKING:
    from pirate_sm.core.companion import Companion
    from pirate_sm.running.recording.format.engine_topics import PlacesSample
    from pirate_sm.running.recording.format.header import RunHeader
    from pirate_sm.running.recording.viewers.live_server import Live
    from pirate_sm.running.recording.write.piece_maker import Pictured, PlacesOfTrail, Sample
    from pirate_sm.running.recording.write.recorder import Recorder
    from pirate_sm.running.recording.write.recording_file import RecordingFile
    from pirate_sm.running.recording.write.sampler import KeptSamples, Look, LookBack, SideChannel
    from pirate_sm.running.runtime.loop import MissionRun


# --- samples --------------------------------------------------------------------------------------


State: TypeAlias = Callable[[], EngineState | None]
"""Returns the engine's state; None before it has started."""


def samples_for_viewers(prepared: Prepared, state: State) -> Look[Sample]:
    """Return a function that takes samples with everything that viewers are shown."""
    from pirate_sm.running.recording.viewers.viewer_messages import ViewerSnapshot
    from pirate_sm.running.recording.write.piece_maker import Sample

    numbers = prepared.engine.numbers

    def look(now_s: float, stood: Stood | None) -> Sample | None:
        now = state()
        if now is None:
            return None
        camera = prepared.camera() if prepared.camera else None
        places, known = _wheels(prepared, stood)
        beside = _space(prepared, stood), _rolls(prepared, stood)
        return Sample(now_s, ViewerSnapshot(now, numbers(now), places, known, camera, *beside))

    return look


def samples_to_keep(prepared: Prepared, state: State) -> Look[PlacesSample | Pictured]:
    """Return a function that takes samples of what the run's inputs do not give again."""
    from pirate_sm.running.recording.format.engine_topics import PlacesSample, places_sample
    from pirate_sm.running.recording.viewers.viewer_messages import WheelPlacing
    from pirate_sm.running.recording.write.piece_maker import Pictured

    true, camera = prepared.wheels, prepared.camera
    if true is not None and camera is None and prepared.in_space is None:
        # Nearly every run at full speed.
        return lambda now_s, stood: (
            places_sample(now_s, True, true(), None, _rolls(prepared, None))
            if stood is None
            else PlacesSample(now_s, True, stood.places_m, (), stood.space.rolls_rad)
        )
    loaded = prepared.loaded
    robot = loaded.loaded_robot.profile, loaded.robot
    placing = WheelPlacing(*robot, loaded.pipe, prepared.order.start_at_m)

    def look(now_s: float, stood: Stood | None) -> PlacesSample | Pictured | None:
        now = state()
        if now is None:
            return None
        places, known = _wheels(prepared, stood)
        taken = places or placing.look(now, now_s) or ()
        beside = _space(prepared, stood), _rolls(prepared, stood)
        sample = places_sample(now_s, known, taken, *beside)
        seen = camera() if camera else None
        return sample if seen is None else Pictured(sample, seen)

    return look


def samples_of_trails(prepared: Prepared) -> LookBack[PlacesOfTrail] | None:
    """Return a function that takes samples to keep, of steps that were taken together.

    It is None if such samples need more than where the robot was.
    """
    from pirate_sm.running.recording.format.engine_topics import PlacesSample
    from pirate_sm.running.recording.write.piece_maker import PlacesOfTrail

    if prepared.wheels is None or prepared.camera is not None:
        return None
    flat = prepared.in_space is None

    def look_back(times_s: Sequence[float], trail: Trail) -> PlacesOfTrail:
        def samples(kept: Sequence[PlacesOfTrail]) -> Iterator[PlacesSample]:
            columns = trail.read([each.noted for each in kept])
            all_s = chain.from_iterable(each.times_s for each in kept)
            for at_s, places_m, z_m, rolls_rad in zip(all_s, *columns, strict=True):
                if flat:
                    yield PlacesSample(at_s, True, places_m, (), rolls_rad)
                else:
                    yield PlacesSample(at_s, True, places_m, (*z_m, *rolls_rad))

        return PlacesOfTrail(times_s, trail.noted(times_s), samples)

    return look_back


def _wheels(prepared: Prepared, stood: Stood | None) -> tuple[tuple[Place, ...] | None, bool]:
    """Return where the wheels are, None if unknown; and whether that is true."""
    if prepared.wheels is not None:
        return prepared.wheels() if stood is None else stood.wheels, True
    taken = prepared.reckoned() if prepared.reckoned else None
    return (taken.wheels if taken else None), False


def _space(prepared: Prepared, stood: Stood | None) -> InSpace | None:
    """Return what the wheels' places leave out of a robot in space; None if unknown."""
    if prepared.in_space is not None:
        return prepared.in_space() if stood is None else stood.space
    taken = prepared.reckoned() if prepared.reckoned else None
    return InSpace(taken.z_m, taken.rolls_rad) if taken is not None and taken.z_m else None


def _rolls(prepared: Prepared, stood: Stood | None) -> tuple[float, ...]:
    """Return the rolls of a simulated robot that moves in a plane; empty for any other one."""
    if prepared.rolls is None:
        return ()
    return prepared.rolls() if stood is None else stood.space.rolls_rad


# --- the recorder ---------------------------------------------------------------------------------


LIVE_S = 0.1
"""Interval at which connected viewers get new data."""


def run_header(
    prepared: Prepared, factor: float, began: datetime, *, live: bool = False
) -> RunHeader:
    """Return the header of a run's recording.

    A run as fast as possible has no messages for viewers, which cost more than all the rest.

    Args:
        prepared: The run.
        factor: Mission seconds per second of the wall clock.
        began: When the run began.
        live: Whether viewers are connected during the run.
    """
    from pydantic_core import to_jsonable_python

    from pirate_sm.running.recording.format.header import header_of

    viewers = live or prepared.backend.real_time or not isinf(factor)
    if prepared.resumed is not None:
        from pirate_sm.running.wiring.resumed_run import header_again

        return header_again(prepared, began, viewers, "max" if isinf(factor) else factor)
    options: dict[str, Any] = to_jsonable_python(prepared.order)
    del options["put_back"]
    options["speed"] = "max" if isinf(factor) else factor
    return header_of(
        prepared.loaded,
        backend=prepared.order.backend,
        nominal=prepared.engine.nominal,
        detector=prepared.detector,
        options=options,
        began=began,
        viewers=viewers,
    )


class RunRecorder:
    """Records the runs of one prepared backend into one file.

    Args:
        prepared: The first run.
        header: The header of the recording.
        file: The recording; None: only connected viewers get data.
        live: Serves viewers during the run; None: there are none.
        watched: Whether another process reads the file meanwhile.

    Attributes:
        recorder: The tap that records every step.
        side: The channel to viewers, or what keeps the samples.
    """

    def __init__(
        self,
        prepared: Prepared,
        header: RunHeader,
        file: RecordingFile | None,
        live: Live | None = None,
        *,
        watched: bool = False,
    ) -> None:
        from pirate_sm.running.recording.write.recorder import COMMIT_S, Recorder
        from pirate_sm.running.recording.write.recording_file import Nowhere, RecordingFile

        self.side: SideChannel | KeptSamples = (
            _side_channel(prepared, live) if header.viewers else _kept_samples(prepared)
        )
        self.recorder: Recorder = Recorder(
            file or RecordingFile(Nowhere(), header),
            header,
            real_time=prepared.backend.real_time,
            side=self.side,
            commit_s=LIVE_S if watched or live is not None else COMMIT_S,
        )

    def follow(self, prepared: Prepared, state: Callable[[], EngineState | None]) -> None:
        """Show a run to viewers, and record its state at intervals."""
        from pirate_sm.running.recording.write.sampler import SideChannel

        self.recorder.follow(state)
        if isinstance(self.side, SideChannel):
            self.side.follow(samples_for_viewers(prepared, state))
        else:
            self.side.follow(samples_to_keep(prepared, state), samples_of_trails(prepared))

    def close(self, path: Path | None, *, wanted: bool = True) -> None:
        """Finish the recording; remove its file if it is empty or not wanted."""
        self.recorder.close()
        if path is not None and not (self.recorder.begun and wanted):
            with suppress(OSError):
                path.unlink()


def _side_channel(prepared: Prepared, live: Live | None) -> SideChannel:
    """Return what makes the messages for viewers."""
    from pirate_sm.running.recording.viewers.viewer_messages import ViewerMessages
    from pirate_sm.running.recording.write.sampler import SideChannel

    return SideChannel(ViewerMessages(prepared.loaded, prepared.order.start_at_m), live)


def _kept_samples(prepared: Prepared) -> KeptSamples:
    """Return what keeps the samples from which messages for viewers can be made."""
    from pirate_sm.running.recording.viewers.viewer_messages import CameraMessages
    from pirate_sm.running.recording.write.sampler import KeptSamples

    wheels = [wheel.name for wheel in prepared.loaded.loaded_robot.profile.body.wheels]
    return KeptSamples(CameraMessages(wheels) if prepared.camera else None)


def new_recording(path: Path, header: RunHeader) -> RecordingFile:
    """Return a new recording with its header written; leave no file if that fails.

    Raises:
        FileExistsError: The file exists already.
        OSError: It cannot be written.
    """
    from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile

    sink = DiskFile(path)
    try:
        return RecordingFile(sink, header)
    except BaseException:
        with suppress(OSError):
            sink.close()
        with suppress(OSError):
            path.unlink()
        raise


def requested_recording(path: Path, header: RunHeader) -> RecordingFile:
    """Return a new recording at a path that the user gave.

    Raises:
        RecordingError: Its name is none for a recording, or the file exists already or cannot be
            written.
    """
    if path.suffix.lower() != ".mcap" or visible(path.name) != path.name:
        name = re.sub(r"[^\w. +-]", "_", path.stem) + ".mcap"
        message = f"'{visible(str(path))}' is not a name for a recording, which is an MCAP file"
        raise RecordingError(f"{message}: name it '{name}'; nothing has moved")
    try:
        return new_recording(path, header)
    except FileExistsError:
        raise RecordingError(f"{shown(path)} exists already; nothing has moved") from None
    except OSError as error:
        problem = f"{shown(path)} cannot be written: {error.strerror}"
        raise RecordingError(f"{problem}; nothing has moved") from None


@dataclass
class Kept:
    """A run with or without a recording.

    Attributes:
        prepared: The run, with notices about its recording.
        recording: The recording; None: there is none.
        companions: The companions for the recording.
        wanted: Whether the recording is kept after the run.
        lost: After the run: the recording that the user asked for and that is incomplete; None:
            it is complete, or nobody asked for one.
    """

    prepared: Prepared
    recording: RunRecorder | None = None
    companions: tuple[Companion, ...] = ()
    wanted: bool = True
    lost: Path | None = None

    @property
    def tap(self) -> Recorder | None:
        """The recorder of the run; None without one."""
        return self.recording.recorder if self.recording is not None else None

    def forget(self) -> None:
        """Discard the recording, because the operator requested nothing in the run."""
        self.wanted = False

    def follow(self, run: MissionRun) -> None:
        """Show this run to viewers, and record its state at intervals."""
        if self.recording is not None:
            self.recording.follow(self.prepared, lambda: run.state)
