"""Writes a recording with all messages for viewers from one that was made without them.

The mission is replayed, and the same code makes the messages as in a run in real time. What cannot
be made again is taken from the recording: positions of wheels, and what a camera saw.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from contextlib import closing, suppress
from dataclasses import replace
from pathlib import Path
from typing import Generic, TypeVar

from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import RecordingError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.running.recording.format.engine_topics import (
    SAMPLES,
    Abandoned,
    Input,
    Placed,
    Started,
    Topics,
    decode_samples,
)
from pirate_sm.running.recording.format.header import REPAIRED
from pirate_sm.running.recording.format.json_values import body_to_text
from pirate_sm.running.recording.read.pieces import RecordedStep
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.replay import Rerun, engine_of, rerun
from pirate_sm.running.recording.viewers.viewer_messages import (
    CameraMessages,
    ViewerMessages,
    ViewerSnapshot,
)
from pirate_sm.running.recording.write.piece_maker import Gathered, PieceMaker, Sample
from pirate_sm.running.recording.write.recording_file import DiskFile, RecordingFile
from pirate_sm.running.recording.write.sampler import SideChannel

T = TypeVar("T")

_EACH_STEPS = 2_000
"""Steps of the engine in one piece of the file."""


def write_complete(recording: Recording, loaded: LoadedMission, path: Path) -> None:
    """Write the recording with messages for viewers to a new file; copy one that has them.

    Raises:
        FileExistsError: The new file exists already; it does not change.
        OSError: It cannot be written; no file is left then.
        RecordingError: The recording is damaged, or a message cannot be made; no file is left.
    """
    with closing(DiskFile(path)) as sink:
        try:
            if recording.header.viewers:
                shutil.copyfile(recording.path, path)
            else:
                _Completed(recording, loaded, sink).write()
        except BaseException:
            with suppress(OSError):
                path.unlink()
            raise


class _Completed:
    """A complete recording being written."""

    def __init__(self, recording: Recording, loaded: LoadedMission, sink: DiskFile) -> None:
        header, body = recording.header, loaded.loaded_robot.profile.body
        self._recording = recording
        self._loaded = loaded
        self._engine = engine_of(recording.header, loaded)
        self._file = RecordingFile(sink, replace(header, viewers=True))
        self._topics = Topics(header.layout)
        self._side = SideChannel(ViewerMessages(loaded, header.options.get("start_at_m")))
        self._camera = CameraMessages([wheel.name for wheel in body.wheels]).channels
        self._seen = _Ahead(recording.messages(*self._camera))

    def write(self) -> None:
        """Write the whole file."""
        recording, file = self._recording, self._file
        file.time_ns(recording.origin_s)  # the beginning, also if its steps are lost
        pieces = PieceMaker(file, self._topics, self._side)
        noted, until_s = Gathered(0, self._topics.channels), 0.0
        samples = _Ahead(_samples(recording))
        after_gaps = {gap.step for gap in recording.gaps}
        for step, state in with_states(rerun(recording, self._loaded)):
            if step.number in after_gaps:  # a piece begins there, as steps are counted in pieces
                self._put(pieces, noted)
                noted = Gathered(step.number, self._topics.channels, noted.until_s)
            noted.add(_input_of(step), step.at_s, step.effects)
            placed = samples.next
            if placed is not None and step.at_s >= placed.at_s and state is not None:
                noted.told.append(Sample(step.at_s, self._snapshot(state, placed)))
                samples.pass_by()
            if step.state is not None:
                noted.remember(step.at_s, step.state)
            if noted.steps >= _EACH_STEPS:
                self._put(pieces, noted)
                noted = noted.next()
            until_s = step.at_s
        self._put(pieces, noted)
        if self._side.failure:
            raise RecordingError(f"messages for viewers cannot be made: {self._side.failure}")
        if not recording.complete:
            torn = recording.content.size - recording.content.whole
            now = {"until_s": repr(until_s), "torn_bytes": str(torn)}
            file.note(REPAIRED, {**recording.repaired, **now})
        file.finish()

    def _put(self, pieces: PieceMaker, noted: Gathered) -> None:
        """Write a piece of the file, with what the camera saw in that time."""
        pieces.take(noted)
        until_ns = self._file.time_ns(noted.until_s or 0.0)
        while (seen := self._seen.next) is not None and seen.time_ns <= until_ns:
            channel = self._camera[seen.topic]
            at = seen.topic, seen.time_ns, seen.data
            self._file.add_at(*at, channel.schema, channel.schema_name)
            self._seen.pass_by()
        self._file.write(pieces.cut().data)

    def _snapshot(self, state: EngineState, placed: Placed) -> ViewerSnapshot:
        wheels = tuple(placed.wheels) or None
        numbers = self._engine.numbers(state)
        beside = placed.space, placed.rolls_rad
        return ViewerSnapshot(state, numbers, wheels, placed.known, None, *beside)


class _Ahead(Generic[T]):
    """An iterator whose next value can be looked at.

    Attributes:
        next: This value; None at the end.
    """

    def __init__(self, values: Iterator[T]) -> None:
        self._values = values
        self.next = next(values, None)

    def pass_by(self) -> None:
        """Advance to the value after the next one."""
        self.next = next(self._values, None)


def with_states(again: Iterable[Rerun]) -> Iterator[tuple[RecordedStep, EngineState | None]]:
    """Yield each step with the engine's state after it, or after the start for steps before it."""
    before: list[RecordedStep] = []
    for each in again:
        if each.state is None:
            before.append(each.step)
            continue
        for step in before:
            yield step, each.state
        before.clear()
        yield each.step, each.state
    for step in before:
        yield step, None


def _samples(recording: Recording) -> Iterator[Placed]:
    """Yield the samples of a recording, at times of the engine's clock."""
    for batch in recording.shown(SAMPLES):
        yield from decode_samples(batch.content)


def _input_of(step: RecordedStep) -> Input:
    """Return what the step was recorded as."""
    if step.by == "start":
        return Started(step.paused, body_to_text(step.body))
    return Abandoned() if step.event is None else step.event
