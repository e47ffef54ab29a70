"""Open the camera of a file: its sightings, live or in mission time.

A live camera is read in a thread, which keeps the newest sighting only. Sightings of a video, of
pictures in files and of a synthetic camera do not depend on how fast this computer is: picture n
is of the time n / rate.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from random import Random
from threading import Event, Lock, Thread

from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import Sighting
from pirate_sm.robot import camera as kinds
from pirate_sm.robot.camera import Camera, CameraSource
from pirate_sm.robot.detectors.vision_detector import SightingSource
from pirate_sm.robot.vision.captures import Capture, first_frame, open_capture
from pirate_sm.robot.vision.opencv import Frame, cv2
from pirate_sm.robot.vision.seeing import Eye, eye_of
from pirate_sm.robot.vision.synthetic import ShownScene, SyntheticPictures

# --- one picture ----------------------------------------------------------------------------------


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


# --- live -----------------------------------------------------------------------------------------


REOPEN_S = 1.0
"""How long after a failure the camera is opened again."""

_LOOK_S = 0.01
"""How often the newest sighting is asked for: a loop's own period, so that nothing is late."""


class LiveSightings:
    """Reads a camera in a thread of its own, which alone waits for it.

    A failure of the camera or of this program's search is never raised in the loop: ``fault`` says
    it, no sightings come, and the camera is opened again each second.

    Args:
        source: What the camera's file says of the pictures.
        eye: Sees the robot in them.
        latency_s: How late a picture arrives.
        opened: Opens the camera.
        wait: Waits for a time, s, or until it is closed; returns whether it is closed. By default
            in real time.
        clock: Returns a time that never leaps, s; each look relates it to the mission's.

    Raises:
        UsageError: The camera cannot be opened now, or its pictures have another size.
    """

    def __init__(
        self,
        source: CameraSource,
        eye: Eye,
        latency_s: float,
        opened: Callable[[], Capture],
        wait: Callable[[float], bool] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.due_s = 0.0
        self.fault = ""
        self._source = source
        self._latency_s = latency_s
        self._clock = clock
        self._ahead_s = -clock()  # mission time less that of the clock
        self._opened = opened
        self._gaze = Gaze(eye)
        self._lock = Lock()
        self._newest: SeenPicture | None = None
        self._closed = Event()
        self._wait = wait or self._closed.wait
        capture = self._open()
        self._thread = Thread(target=self._run, args=(capture,), name="camera", daemon=True)
        self._thread.start()

    def look(self, now_s: float) -> Sequence[SeenPicture]:
        """Return the newest sighting if it has not been handed out yet."""
        self.due_s, self._ahead_s = now_s + _LOOK_S, now_s - self._clock()
        with self._lock:
            newest, self._newest = self._newest, None
        return () if newest is None else (newest,)

    def close(self) -> None:
        """End the thread; one that waits for a camera that hangs is left alone."""
        self._closed.set()
        self._thread.join(timeout=1.0)

    def _open(self) -> Capture:
        """Return the opened camera; its first picture is only looked at."""
        capture = self._opened()
        try:
            first_frame(capture, self._source)
        except BaseException:
            capture.close()
            raise
        return capture

    def _run(self, capture: Capture | None) -> None:
        while not self._closed.is_set():
            try:
                capture = capture or self._open()
                self.fault = ""
                self._read(capture)
                self.fault = "the camera gives no more pictures"
            except UsageError as error:
                self.fault = str(error)
            except Exception as error:  # whatever happens in here, the loop goes on
                self.fault = f"{type(error).__name__}: {error}"
            if capture is not None:
                with suppress(Exception):
                    capture.close()
                capture = None
            if self._wait(REOPEN_S):
                return

    def _read(self, capture: Capture) -> None:
        """Read and see until the camera ends, or until it is closed."""
        while not self._closed.is_set():
            frame = capture.read()
            if frame is None:
                return
            seen = self._gaze.see(frame, self._clock() + self._ahead_s - self._latency_s)
            with self._lock:
                self._newest = seen


# --- in mission time ------------------------------------------------------------------------------


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


# --- the camera of a file -------------------------------------------------------------------------


def open_sightings(
    camera: Camera, folder: Path, scene: Callable[[], ShownScene] | None = None, seed: int = 0
) -> SightingSource:
    """Return the sightings of a camera; it is open and has given a picture.

    Args:
        camera: What its file says.
        folder: The folder of the file, to which its paths refer.
        scene: Returns the simulated robot as it is now; for synthetic cameras.
        seed: Of the errors of a synthetic camera.

    Raises:
        UsageError: The camera cannot be opened, its pictures have another size, its lens or its
            place is unknown, or it is synthetic and no robot is simulated.
    """
    source, eye = camera.source, eye_of(camera)
    match source:
        case kinds.DeviceSource() | kinds.UrlSource():
            opened = partial(open_capture, source, folder)
            return LiveSightings(source, eye, camera.latency_s, opened)
        case kinds.FileSource() | kinds.ImagesSource():
            capture = open_capture(source, folder)
            return RecordedSightings(source, eye, camera.latency_s, capture)
        case kinds.SyntheticSource():
            if scene is None:
                raise UsageError(
                    f"the camera '{camera.camera}' is synthetic: it sees a simulated robot only"
                )
            pictures = SyntheticPictures(camera, eye.view, source.synthetic)
            return SyntheticSightings(eye, pictures, scene, seed)
