"""A sighting with its picture, and an eye that remembers where the marker was."""

from __future__ import annotations

from dataclasses import dataclass, field

from pirate_sm.core.events import Sighting
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.picture_arrays import Frame
from pirate_sm.robot.vision.seeing import Eye

_JPEG_QUALITY = 70


@dataclass(frozen=True)
class SeenPicture:
    """A sighting and its picture.

    Attributes:
        sighting: What was found.
        frame: The picture.
    """

    sighting: Sighting
    frame: Frame = field(repr=False)

    def jpeg(self, width: int = 640) -> bytes:
        """Return the picture as a small JPEG, for recordings: 16 kB at a width of 640 pixels."""
        height = round(self.frame.shape[0] * width / self.frame.shape[1])
        small = cv2.resize(self.frame, (width, height), interpolation=cv2.INTER_AREA)
        coded = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1]
        return bytes(coded.tobytes())


class Gaze:
    """An eye that remembers where the marker was, so that it searches there first.

    Args:
        eye: The eye.
    """

    _REMEMBERED_S = 0.5

    def __init__(self, eye: Eye) -> None:
        self._eye = eye
        self._last: tuple[float, tuple[float, float]] | None = None

    def see(self, frame: Frame, captured_s: float) -> SeenPicture:
        """Return what a picture shows."""
        near = None
        if self._last is not None and 0 <= captured_s - self._last[0] <= self._REMEMBERED_S:
            near = self._last[1]
        sighting = self._eye.see(frame, captured_s, near)
        if sighting.marks:
            self._last = captured_s, sighting.marks[0].place_m
        return SeenPicture(sighting, frame)
