"""Messages about a detector's camera: where it sees the wheels, and its pictures."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Iterator, Sequence
from math import isfinite

from pirate_sm.robot.detectors.vision_detector import CameraView
from pirate_sm.running.recording.viewers.viewer_channel import (
    NUMBER,
    Message,
    ViewerChannel,
    flat,
    foxglove,
    stamp,
)

PICTURES = "/camera"
"""The topic with the camera's pictures."""


class CameraMessages:
    """Makes the messages of one run.

    Args:
        wheels: Names of the wheels.
    """

    def __init__(self, wheels: Sequence[str]) -> None:
        self._names = [f"{name}_m" for name in wheels]
        columns = (*self._names, "marks", "rms_px", "gray_spread", "age_s")
        self._seen = flat("/vision", dict.fromkeys(columns, NUMBER))
        self._pictures = foxglove(PICTURES, "CompressedImage")

    @property
    def channels(self) -> dict[str, ViewerChannel]:
        """Return the topics by their names."""
        return {channel.topic: channel for channel in (self._seen, self._pictures)}

    def of(self, at_s: float, time_ns: int, view: CameraView) -> Iterator[Message]:
        """Yield where the camera sees the wheels along the pipe, and its picture if there is one.

        Unknown numbers are left out.
        """
        sighting = view.sighting
        numbers = dict(zip(self._names, view.seen.places_m, strict=True))
        numbers |= {
            "marks": len(sighting.marks),
            "gray_spread": sighting.gray_spread,
            "age_s": at_s - sighting.captured_s,
        }
        if sighting.rms_px is not None:
            numbers["rms_px"] = sighting.rms_px
        known = {name: round(value, 6) for name, value in numbers.items() if isfinite(value)}
        yield self._seen, json.dumps(known).encode()
        if view.jpeg:
            yield self._pictures, self._picture(time_ns, view.jpeg)

    @staticmethod
    def _picture(time_ns: int, jpeg: bytes) -> bytes:
        data = b64encode(jpeg).decode()
        head = f'{{"timestamp":{stamp(time_ns)},"frame_id":"camera","format":"jpeg"'
        return f'{head},"data":"{data}"}}'.encode()
