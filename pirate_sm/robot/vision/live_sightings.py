"""Sightings of a live camera: a thread reads and sees, and keeps the newest only."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from threading import Event, Lock, Thread

from pirate_sm.core.camera import CameraSource
from pirate_sm.core.errors import UsageError
from pirate_sm.robot.vision.captures import Capture, first_frame
from pirate_sm.robot.vision.gaze import Gaze, SeenPicture
from pirate_sm.robot.vision.seeing import Eye

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
