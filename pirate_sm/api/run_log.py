"""Notes what happens in a run while it goes on, in memory and, if wanted, in a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from math import inf
from os import PathLike
from pathlib import Path
from typing import Generic, TypeVar

from pirate_sm.api.arguments import path_of
from pirate_sm.api.result import Run
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event
from pirate_sm.core.resuming import AS_DECLARED, Beginning
from pirate_sm.core.sensing import Glide
from pirate_sm.core.simulation import Trail
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.read.pieces import RecordedStep
from pirate_sm.running.recording.write.recorder import Recorder
from pirate_sm.running.wiring import Prepared
from pirate_sm.running.wiring.run_recorder import RunRecorder, requested_recording, run_header
from pirate_sm.views.report.poses import EVERY_S, Poses

T = TypeVar("T")


@dataclass(frozen=True)
class _Same(Generic[T]):
    """A function that returns one value; other processes can be sent it, which a lambda cannot."""

    value: T

    def __call__(self) -> T:
        return self.value


class Notes:
    """A tap that keeps every step in memory and passes it on to a recorder.

    Args:
        prepared: The run.
        header: What was run.
        recorder: Who else keeps the steps.

    Attributes:
        stepwise: Whether the recorder looks at the run after each step.
    """

    def __init__(self, prepared: Prepared, header: RunHeader, recorder: Recorder | None) -> None:
        self._prepared = prepared
        self._header = header
        self._recorder = recorder
        self._steps: list[RecordedStep] = []
        self._poses = Poses(true=True)
        self._pose_s = 0.0
        self._trail: Trail | None = None
        self.stepwise = recorder is not None and recorder.stepwise

    @property
    def due_s(self) -> float:
        """Return when the recorder looks at the engine next."""
        return inf if self._recorder is None else self._recorder.due_s

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Note how the engine started."""
        if self._recorder is not None:
            self._recorder.start(seen, now_s, effects, begins)
        number = len(self._steps)
        self._steps += [
            RecordedStep(number + n, now_s, event, (), "seen") for n, event in enumerate(seen)
        ]
        number = len(self._steps)
        start = RecordedStep(number, now_s, None, tuple(effects), "start", **begins._asdict())
        self._steps.append(start)
        self._pose(now_s)

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Note one step of the engine."""
        if self._recorder is not None:
            self._recorder.take(event, now_s, effects)
        self._steps.append(RecordedStep(len(self._steps), now_s, event, tuple(effects), "engine"))
        self._pose(now_s)

    def secure(self) -> None:
        """Return when all that was noted is on the disk, or soon if that takes too long."""
        if self._recorder is not None:
            self._recorder.secure()

    def take_glide(self, glide: Glide) -> None:
        """Note the steps of the engine that were taken at once, and the poses at them."""
        if self._recorder is not None:
            self._recorder.take_glide(glide)
        self._trail = glide.trail
        for number, (at_s, event, effects) in enumerate(glide.in_order(), len(self._steps)):
            self._steps.append(RecordedStep(number, at_s, event, effects, "engine"))
            self._pose(at_s)

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Note what was done past the engine."""
        if self._recorder is not None:
            self._recorder.abandon(now_s, effects)
        self._steps.append(RecordedStep(len(self._steps), now_s, None, tuple(effects), "runtime"))

    def run(self, *notices: str) -> Run:
        """Return the run as far as it has come.

        Args:
            notices: What its reader must know; empty ones are left out.
        """
        failure = self._recorder.failure if self._recorder is not None else ""
        early = f"the recording ends early: {failure}" if failure else ""
        poses = self._poses.thinned()
        return Run(
            self._prepared.loaded,
            self._header,
            steps=_Same(tuple(self._steps)),
            poses=_Same(poses if poses.times_s else None),
            gaps=(),
            notices=tuple(text for text in (early, *notices) if text),
        )

    def _pose(self, now_s: float) -> None:
        wheels, in_space = self._prepared.wheels, self._prepared.in_space
        if wheels is not None and now_s >= self._pose_s:
            self._pose_s = now_s + EVERY_S
            stood = None if self._trail is None else self._trail.at(now_s)
            if stood is None:
                self._poses.add(now_s, wheels(), in_space() if in_space else None)
            else:
                self._poses.add(now_s, stood.wheels, stood.space if in_space else None)


@contextmanager
def noted(
    prepared: Prepared, record: str | PathLike[str] | None, state: Callable[[], EngineState | None]
) -> Iterator[Notes]:
    """Keep notes of a run until the block ends.

    Args:
        prepared: The run.
        record: A file that must not exist, for a recording; None: there is none.
        state: Returns the engine's state after the step that was noted last.

    Raises:
        RecordingError: The file cannot be made.
        UsageError: It is no path.
    """
    header = run_header(prepared, inf, datetime.now(UTC).astimezone())
    if record is None:
        yield Notes(prepared, header, None)
        return
    path = Path(path_of(record))
    recording = RunRecorder(prepared, header, requested_recording(path, header))
    recording.follow(prepared, state)
    try:
        yield Notes(prepared, header, recording.recorder)
    finally:
        recording.close(path)
