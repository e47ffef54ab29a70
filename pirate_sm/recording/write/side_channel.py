"""Messages for viewers, written to the recording beside the engine's topics, and served live.

Nothing depends on it: an error here ends the side channel, neither the recording nor the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import inf
from typing import NamedTuple, Protocol

from pirate_sm.model.effects import Effect
from pirate_sm.recording.viewers.viewer_messages import (
    Message,
    ViewerChannel,
    ViewerMessages,
    ViewerSnapshot,
)
from pirate_sm.recording.write.recording_file import RecordingFile

EVERY_S = 0.1
"""The robot is drawn this often, mission time, s."""

_SCENE_EVERY = 10
"""The scene is shown again after this many samples, for viewers that connect late."""


class Audience(Protocol):
    """Viewers that are connected while the run goes on."""

    def show(self, channel: ViewerChannel, time_ns: int, data: bytes) -> None:
        """Send the message to the viewers."""
        ...


class Sample(NamedTuple):
    """Where a run stood at a moment."""

    at_s: float
    snapshot: ViewerSnapshot


class SideChannel:
    """Takes a look at the run now and then, and makes messages of what it sees.

    Args:
        viewer: What makes the messages.
        audience: Who sees them at once.

    Attributes:
        due_s: Mission time of the next look.
        failure: Why there are none any more; empty while all is well.
    """

    def __init__(self, viewer: ViewerMessages, audience: Audience | None = None) -> None:
        self.due_s = 0.0
        self.failure = ""
        self._viewer = viewer
        self._audience = audience
        self._look: Callable[[], ViewerSnapshot | None] = lambda: None
        self._samples = 0

    def follow(self, look: Callable[[], ViewerSnapshot | None]) -> None:
        """Set the function that returns where the run stands; None before it has begun."""
        self._look = look

    def look(self, now_s: float) -> Sample | None:
        """Return where the run stands; None before it has begun."""
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

    def tell(self, file: RecordingFile, at_s: float, effects: Sequence[Effect]) -> None:
        """Add the messages that effects lead to to the file and show them to the audience."""
        time_ns = file.time_ns(at_s)
        self._put(file, at_s, time_ns, lambda: self._viewer.tell(time_ns, effects))

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
