"""Messages for viewers, beside the engine's topics in the recording, and served live.

Nothing depends on them: an error here ends the side channel, not the recording or the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import inf
from typing import NamedTuple, Protocol

from pirate_sm.model.effects import Effect
from pirate_sm.recording.viewers.viewer_channel import Message, ViewerChannel
from pirate_sm.recording.viewers.viewer_messages import ViewerMessages, ViewerSnapshot
from pirate_sm.recording.write.recording_file import RecordingFile

EVERY_S = 0.1
"""Interval at which the robot is drawn, mission time, s."""

_SCENE_EVERY = 10
"""The scene is repeated after this many samples, for viewers that connect late."""


class Audience(Protocol):
    """Viewers that are connected during the run."""

    def show(self, channel: ViewerChannel, time_ns: int, data: bytes) -> None:
        """Send the message to the viewers."""


class Sample(NamedTuple):
    """The state of a run at one time."""

    at_s: float
    snapshot: ViewerSnapshot


class SideChannel:
    """Samples the run at intervals, and makes messages of the samples.

    Args:
        viewer: Makes the messages.
        audience: Shows them at once.

    Attributes:
        due_s: Mission time of the next sample.
        failure: Why there are no more messages; empty while there are.
    """

    def __init__(self, viewer: ViewerMessages, audience: Audience | None = None) -> None:
        self.due_s = 0.0
        self.failure = ""
        self._viewer = viewer
        self._audience = audience
        self._look: Callable[[], ViewerSnapshot | None] = lambda: None
        self._samples = 0

    def follow(self, look: Callable[[], ViewerSnapshot | None]) -> None:
        """Set the function that returns the state of the run; None before it has begun."""
        self._look = look

    def look(self, now_s: float) -> Sample | None:
        """Return the state of the run; None before it has begun."""
        self.due_s = now_s + EVERY_S
        try:
            snapshot = self._look()
        except Exception as error:
            self._fail(error)
            return None
        return None if snapshot is None else Sample(now_s, snapshot)

    def show(self, file: RecordingFile, sample: Sample) -> None:
        """Add the sample to the file and show it to the audience."""
        at_s, viewer = sample.at_s, self._viewer
        time_ns = file.time_ns(at_s)
        first, late = self._samples == 0, self._samples % _SCENE_EVERY == 0
        self._samples += 1
        if first or (late and self._audience is not None):
            self._put(file if first else None, at_s, time_ns, lambda: [viewer.scene(time_ns)])
        self._put(file, at_s, time_ns, lambda: viewer.sample(at_s, time_ns, sample.snapshot))

    def show_effects(self, file: RecordingFile, at_s: float, effects: Sequence[Effect]) -> None:
        """Write the messages about effects to the file and show them to the audience."""
        time_ns = file.time_ns(at_s)
        self._put(file, at_s, time_ns, lambda: self._viewer.of_effects(time_ns, effects))

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
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self.failure = f"{type(error).__name__}: {error}"
        self.due_s = inf
