"""Looks at a run at intervals, for what a recording holds in addition to the engine's topics.

That is messages for viewers, which are also served live, or samples from which they can be made
later. Nothing depends on it: an error here ends the samples, not the recording or the run.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from math import inf
from typing import Generic, Protocol, TypeAlias, TypeVar

from pirate_sm.core.events import Stood, Trail
from pirate_sm.running.recording.format.engine_topics import (
    SAMPLES,
    SAMPLES_SCHEMA,
    SAMPLES_SCHEMA_NAME,
    PlacesSample,
    encode_samples,
)
from pirate_sm.running.recording.viewers.viewer_messages import (
    CameraMessages,
    Message,
    ViewerChannel,
    ViewerMessages,
)
from pirate_sm.running.recording.write.piece_maker import (
    Caused,
    Pictured,
    PlacesOfTrail,
    Sample,
    Told,
)
from pirate_sm.running.recording.write.recording_file import RecordingFile

# --- samples --------------------------------------------------------------------------------------


EVERY_S = 0.1
"""Interval of the samples, mission time, s."""

Taken = TypeVar("Taken")

Look: TypeAlias = Callable[[float, Stood | None], Taken | None]
"""Returns a sample, as :meth:`Sampler.look` does."""

LookBack: TypeAlias = Callable[[Sequence[float], Trail], Taken]
"""Returns samples of these times, s, from where the robot was."""


def due_steps(times_s: Sequence[float], due_s: float, every_s: float) -> list[float]:
    """Return the times of the steps that are due from a time on, each so long after the last."""
    due = list[float]()
    while times_s and times_s[-1] >= due_s:
        due.append(times_s[bisect_left(times_s, due_s)])
        due_s = due[-1] + every_s
    return due


class Sampler(Generic[Taken]):
    """Takes samples of the run.

    Attributes:
        due_s: Mission time of the next sample.
        failure: Why there are no more samples; empty while there are.
    """

    def __init__(self) -> None:
        self.due_s = 0.0
        self.failure = ""
        self._look: Look[Taken] = lambda now_s, stood: None
        self._look_back: LookBack[Taken] | None = None

    @property
    def follows_trails(self) -> bool:
        """Return whether it needs no more than to know where the robot was."""
        return self._look_back is not None

    def follow(self, look: Look[Taken], look_back: LookBack[Taken] | None = None) -> None:
        """Set the functions that take samples of the run.

        Args:
            look: Takes one sample.
            look_back: Takes many together; None if it needs more than where the robot was.
        """
        self._look, self._look_back = look, look_back

    def look(self, now_s: float, stood: Stood | None = None) -> Taken | None:
        """Return a sample; None before the run has begun.

        Args:
            now_s: Mission time, s.
            stood: Where the robot was then, if it has moved since; None: where it is now.
        """
        self.due_s = now_s + EVERY_S
        try:
            return self._look(now_s, stood)
        except Exception as error:
            self.fail(error)
            return None

    def look_back(self, times_s: Sequence[float], trail: Trail) -> Taken | None:
        """Return the samples that are due at steps of these times; None without any.

        Args:
            times_s: Mission times, s, never decreasing.
            trail: Where the robot was then.
        """
        if self._look_back is None:
            return None
        due = due_steps(times_s, self.due_s, EVERY_S)
        self.due_s = due[-1] + EVERY_S if due else self.due_s
        try:
            return self._look_back(due, trail) if due else None
        except Exception as error:
            self.fail(error)
            return None

    def fail(self, error: Exception) -> None:
        """End the samples because of this error."""
        self.failure = f"{type(error).__name__}: {error}"
        self.due_s = inf


# --- samples that are kept ------------------------------------------------------------------------


class KeptSamples(Sampler[PlacesSample | PlacesOfTrail | Pictured]):
    """Samples the run at intervals, and keeps only what its inputs do not give again.

    A sample is numbers at once: one that held the engine's state would keep that in memory.

    Args:
        camera: Makes the messages about a detector's camera; None without one.
    """

    def __init__(self, camera: CameraMessages | None = None) -> None:
        super().__init__()
        self._camera = camera

    def tell(self, file: RecordingFile, told: Sequence[Told]) -> None:
        """Add one batch of the samples to the file, and what the camera saw."""
        samples = list[PlacesSample]()
        trails = [each for each in told if isinstance(each, PlacesOfTrail)]
        of_trails = trails[0].samples(trails) if trails else iter(())
        for each in told:
            if isinstance(each, Pictured):
                self._show(file, each)
                samples.append(each.sample)
            elif isinstance(each, PlacesSample):
                samples.append(each)
            elif isinstance(each, PlacesOfTrail):
                samples += islice(of_trails, len(each.times_s))
        if samples:
            file.add(
                SAMPLES,
                samples[0].at_s,
                encode_samples(samples),
                SAMPLES_SCHEMA,
                SAMPLES_SCHEMA_NAME,
            )

    def _show(self, file: RecordingFile, it: Pictured) -> None:
        at_s = it.sample.at_s
        if self._camera is None or self.failure:
            return
        try:
            for channel, data in self._camera.of(at_s, file.time_ns(at_s), it.camera):
                file.add(channel.topic, at_s, data, channel.schema, channel.schema_name)
        except Exception as error:
            self.fail(error)


# --- messages for viewers -------------------------------------------------------------------------


_SCENE_EVERY = 10
"""The scene is repeated after this many samples, for viewers that connect late."""


class Audience(Protocol):
    """Viewers that are connected during the run."""

    def show(self, channel: ViewerChannel, time_ns: int, data: bytes) -> None:
        """Send the message to the viewers."""


class SideChannel(Sampler[Sample]):
    """Samples the run at intervals, and makes messages of the samples.

    Args:
        viewer: Makes the messages.
        audience: Shows them immediately.
    """

    def __init__(self, viewer: ViewerMessages, audience: Audience | None = None) -> None:
        super().__init__()
        self._viewer = viewer
        self._audience = audience
        self._samples = 0

    def tell(self, file: RecordingFile, told: Sequence[Told]) -> None:
        """Add messages about effects and samples to the file, and show them to the audience."""
        for each in told:
            if isinstance(each, Sample):
                self._show(file, each)
            elif isinstance(each, Caused):
                self._show_effects(file, each)

    def _show(self, file: RecordingFile, sample: Sample) -> None:
        at_s, viewer = sample.at_s, self._viewer
        time_ns = file.time_ns(at_s)
        first, late = self._samples == 0, self._samples % _SCENE_EVERY == 0
        self._samples += 1
        if first or (late and self._audience is not None):
            self._put(file if first else None, at_s, time_ns, lambda: [viewer.scene(time_ns)])
        self._put(file, at_s, time_ns, lambda: viewer.sample(at_s, time_ns, sample.snapshot))

    def _show_effects(self, file: RecordingFile, it: Caused) -> None:
        time_ns = file.time_ns(it.at_s)
        self._put(file, it.at_s, time_ns, lambda: self._viewer.of_effects(time_ns, it.effects))

    def _put(
        self,
        file: RecordingFile | None,
        at_s: float,
        time_ns: int,
        make: Callable[[], Iterable[Message]],
    ) -> None:
        if self.failure:
            return
        try:
            for channel, data in make():
                if file is not None:
                    file.add(channel.topic, at_s, data, channel.schema, channel.schema_name)
                if self._audience is not None:
                    self._audience.show(channel, time_ns, data)
        except Exception as error:
            self.fail(error)
