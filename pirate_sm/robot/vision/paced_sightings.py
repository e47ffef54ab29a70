"""Sightings in mission time: of a video, of pictures in files, of a synthetic camera.

They do not depend on how fast this computer is: picture n is of the time n / rate.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from math import inf
from random import Random

from pirate_sm.core.camera import CameraSource
from pirate_sm.core.errors import UsageError
from pirate_sm.robot.vision.captures import Capture, first_frame
from pirate_sm.robot.vision.gaze import Gaze, SeenPicture
from pirate_sm.robot.vision.picture_arrays import Frame
from pirate_sm.robot.vision.seeing import Eye
from pirate_sm.robot.vision.synthetic.picture import SyntheticPictures
from pirate_sm.robot.vision.synthetic.shown_scene import ShownScene

_EARLY_S = 1e-9  # times are sums of periods, which are not exact


class RecordedSightings:
    """Sightings of a video or of pictures in files, which begins with the mission.

    Args:
        source: What the camera's file says of the pictures.
        eye: Sees the robot in them.
        latency_s: How late a picture arrives.
        capture: The opened video.

    Raises:
        UsageError: There are no pictures, or they have another size.
    """

    def __init__(self, source: CameraSource, eye: Eye, latency_s: float, capture: Capture) -> None:
        self.fault = ""
        self._period_s = 1 / source.rate
        self._latency_s = latency_s
        self._capture = capture
        self._gaze = Gaze(eye)
        self._number = 0
        self._next: Frame | None = first_frame(capture, source)
        self.due_s = latency_s

    def look(self, now_s: float) -> Sequence[SeenPicture]:
        """Return what the pictures show that have arrived until now."""
        found = []
        while self._next is not None and self.due_s <= now_s + _EARLY_S:
            found.append(self._gaze.see(self._next, self._number * self._period_s))
            self._number += 1
            self._next = self._read()
            self.due_s = self._number * self._period_s + self._latency_s
        if self._next is None:
            self.due_s = inf
        return found

    def _read(self) -> Frame | None:
        """Return the next picture; None, with the reason in ``fault``, if there is none."""
        try:
            frame = self._capture.read()
        except UsageError as error:
            self.fault = str(error)
            return None
        if frame is None:
            self.fault = "the video is over"
        return frame

    def close(self) -> None:
        """Close the video."""
        self._capture.close()


class SyntheticSightings:
    """Sightings of a synthetic camera over a simulated robot.

    Args:
        eye: Sees the robot in the pictures.
        pictures: Draws them.
        scene: Returns the robot as it is now.
        seed: Of noise and lost pictures.
    """

    def __init__(
        self, eye: Eye, pictures: SyntheticPictures, scene: Callable[[], ShownScene], seed: int
    ) -> None:
        self.due_s = 0.0
        self.fault = ""
        self._eye, self._pictures, self._scene = eye, pictures, scene
        self._seed = seed
        self._gaze = Gaze(eye)
        self._chance = Random(f"synthetic camera {seed}")
        self._number = 0
        self._before: tuple[float, ShownScene] | None = None
        self._under_way: deque[tuple[float, SeenPicture]] = deque()

    def look(self, now_s: float) -> Sequence[SeenPicture]:
        """Take the picture that is due now, and return what has arrived."""
        period_s = 1 / self._eye.camera.source.rate
        if self._number * period_s <= now_s + _EARLY_S:
            self._take(now_s)
            self._number = int((now_s + _EARLY_S) / period_s) + 1
        found = []
        while self._under_way and self._under_way[0][0] <= now_s + _EARLY_S:
            found.append(self._under_way.popleft()[1])
        arrival_s = self._under_way[0][0] if self._under_way else inf
        self.due_s = min(self._number * period_s, arrival_s)
        return found

    def close(self) -> None:
        """Do nothing: nothing is open."""

    def _take(self, now_s: float) -> None:
        """Take a picture of the robot as it is now, unless it is lost."""
        scene = self._scene()
        errors = self._pictures.looks.camera
        if self._chance.random() >= errors.lost:
            opened = None
            if self._before is not None and now_s > self._before[0]:
                # The robot as it was when the shutter opened, on the way since the last picture.
                share = 1 - min(errors.shutter / (now_s - self._before[0]), 1.0)
                opened = scene.moved(self._before[1], share)
            frame = self._pictures.picture(scene, self._number, opened, self._seed)
            seen = self._gaze.see(frame, now_s)
            self._under_way.append((now_s + self._eye.camera.latency_s, seen))
        self._before = now_s, scene
