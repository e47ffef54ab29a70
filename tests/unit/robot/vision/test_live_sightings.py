"""A live camera: the newest picture only, and failures that never reach the loop."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from threading import Event

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.vision.opencv import Frame
from pirate_sm.robot.vision.sightings import LiveSightings

from .small_setup import drawn, scene

LIMIT_S = 20.0


class FakeCamera:
    """Gives the pictures that are put into a queue; None, or an error, ends it."""

    def __init__(self) -> None:
        self.waiting: Queue[Frame | Exception | None] = Queue()
        self.asked = Event()
        self.opened = 0
        self.closed = 0

    def __call__(self) -> FakeCamera:
        self.opened += 1
        return self

    def read(self) -> Frame | None:
        if self.waiting.empty():
            self.asked.set()
        given = self.waiting.get(timeout=LIMIT_S)
        if isinstance(given, Exception):
            raise given
        return given

    def close(self) -> None:
        self.closed += 1

    def settle(self) -> None:
        """Wait until all pictures so far have been seen."""
        self.asked.clear()
        if self.waiting.empty():
            return
        assert self.asked.wait(LIMIT_S)


@pytest.fixture
def frame() -> Frame:
    _, pictures = drawn()
    return pictures.picture(scene(), 0)


@pytest.fixture
def started(frame: Frame) -> Callable[..., tuple[FakeCamera, LiveSightings, Event]]:
    camera, reopen = FakeCamera(), Event()
    camera.waiting.put(frame)

    def start(clock: Callable[[], float] = lambda: 2.0):
        eye, _ = drawn()

        def wait(_: float) -> bool:
            reopen.wait(LIMIT_S)
            reopen.clear()
            return False

        live = LiveSightings(eye.camera.source, eye, 0.1, camera, wait, clock)
        return camera, live, reopen

    return start


def until(condition: Callable[[], bool]) -> None:
    """Wait for a thread, without a fixed time."""
    pause = Event()
    for _ in range(2000):
        if condition():
            return
        pause.wait(0.01)
    raise AssertionError("the thread has not done it")


def test_only_the_newest_picture_is_handed_out_and_only_once(started, frame: Frame) -> None:
    camera, live, _ = started()
    for shade in (0, 1, 2):
        camera.waiting.put(np.clip(frame.astype(int) + shade, 0, 255).astype(np.uint8))
    camera.settle()

    (seen,) = live.look(0.0)

    assert seen.sighting.captured_s == pytest.approx(-0.1)  # it came with the mission, 0.1 late
    assert (seen.frame >= frame).all()
    assert (seen.frame > frame).any()
    assert live.look(5.0) == ()
    camera.waiting.put(frame)
    camera.settle()
    (later,) = live.look(5.0)
    assert later.sighting.captured_s == pytest.approx(4.9)
    camera.waiting.put(None)


def test_a_camera_that_hangs_holds_nothing_up(started) -> None:
    camera, live, _ = started()
    assert camera.asked.wait(LIMIT_S)  # nothing comes any more

    assert [live.look(t) for t in (0.0, 0.5, 1.0)] == [(), (), ()]
    camera.waiting.put(None)


@pytest.mark.parametrize("end", [None, RuntimeError("USB gone")], ids=["unplugged", "error"])
def test_a_camera_that_fails_is_opened_again(started, frame: Frame, end: Exception | None) -> None:
    camera, live, reopen = started()
    camera.waiting.put(end)
    until(lambda: live.fault != "")

    assert live.fault in ("the camera gives no more pictures", "RuntimeError: USB gone")
    assert live.look(0.0) == ()
    until(lambda: camera.closed == 1)

    camera.waiting.put(frame)  # looked at when it is opened
    camera.waiting.put(frame)
    reopen.set()
    until(lambda: live.fault == "" and camera.opened == 2)
    until(lambda: len(live.look(1.0)) == 1)
    camera.waiting.put(None)


def test_a_camera_that_comes_back_with_another_size_stays_a_fault(started) -> None:
    camera, live, reopen = started()
    camera.waiting.put(None)
    until(lambda: camera.closed == 1)
    camera.waiting.put(np.zeros((96, 128, 3), np.uint8))
    reopen.set()

    until(lambda: "128 × 96" in live.fault)
    assert live.fault.startswith("the pictures have")
    assert live.look(0.0) == ()


def test_a_picture_that_breaks_the_search_is_a_fault_and_no_error(started) -> None:
    camera, live, _ = started()
    camera.waiting.put(np.zeros((4, 4), np.uint8))  # no colours

    until(lambda: live.fault != "")
    assert live.look(0.0) == ()


def test_it_is_refused_before_anything_moves(frame: Frame) -> None:
    camera, (eye, _) = FakeCamera(), drawn()
    camera.waiting.put(None)

    with pytest.raises(UsageError, match="gives no picture"):
        LiveSightings(eye.camera.source, eye, 0.0, camera)
    assert camera.closed == 1


def test_closing_ends_the_thread(started) -> None:
    camera, live, reopen = started()
    camera.waiting.put(None)
    until(lambda: camera.closed == 1)
    live._closed.set()
    reopen.set()
    live.close()

    assert not live._thread.is_alive()
