"""Messages for viewers, beside the engine's topics in the recording, and served live."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from pirate_sm.running.recording.viewers.viewer_channel import Message, ViewerChannel
from pirate_sm.running.recording.viewers.viewer_messages import ViewerMessages
from pirate_sm.running.recording.write.gathered import Caused, Sample, Told
from pirate_sm.running.recording.write.recording_file import RecordingFile
from pirate_sm.running.recording.write.sampler import Sampler

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
        audience: Shows them at once.
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
