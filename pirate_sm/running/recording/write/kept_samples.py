"""Samples of a run beside the engine's topics, in a recording without messages for viewers."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice

from pirate_sm.running.recording.format.samples import (
    SAMPLES,
    SCHEMA,
    SCHEMA_NAME,
    PlacesSample,
    encode_samples,
)
from pirate_sm.running.recording.viewers.camera_messages import CameraMessages
from pirate_sm.running.recording.write.gathered import Pictured, PlacesOfTrail, Told
from pirate_sm.running.recording.write.recording_file import RecordingFile
from pirate_sm.running.recording.write.sampler import Sampler


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
            file.add(SAMPLES, samples[0].at_s, encode_samples(samples), SCHEMA, SCHEMA_NAME)

    def _show(self, file: RecordingFile, it: Pictured) -> None:
        at_s = it.sample.at_s
        if self._camera is None or self.failure:
            return
        try:
            for channel, data in self._camera.of(at_s, file.time_ns(at_s), it.camera):
                file.add(channel.topic, at_s, data, channel.schema, channel.schema_name)
        except Exception as error:
            self.fail(error)
