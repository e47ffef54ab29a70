"""What has passed without the engine is given in the order of time."""

from __future__ import annotations

from pirate_sm.core._engine.gliding.quiet_frames import Glide
from pirate_sm.core._model.events import FrameBlock, SensorFrame, Tick
from pirate_sm.core.effects import WakeAt

ROWS = [[float(number)] for number in range(5)]
FRAMES = FrameBlock([0.1, 0.2, 0.3, 0.4, 0.5], [22, 23, 22, 23, 22], ROWS, {22: 1, 23: 1})
QUIET = [(at_s, frame, ()) for at_s, frame in FRAMES.frames()]


def test_another_step_stands_between_the_frames_before_and_after_it() -> None:
    step = 0.25, Tick(), (WakeAt(0.5),)
    glide = Glide(0.5, None, FRAMES, [step])

    assert list(glide.in_order()) == [*QUIET[:2], step, *QUIET[2:]]
    assert list(glide.times_s()) == [0.1, 0.2, 0.25, 0.3, 0.4, 0.5]


def test_another_step_comes_after_a_frame_of_the_same_time() -> None:
    step = 0.3, Tick(), (WakeAt(0.5),)

    assert list(Glide(0.5, None, FRAMES, [step]).in_order()) == [*QUIET[:3], step, *QUIET[3:]]


def test_a_step_of_a_frame_stands_in_its_place() -> None:
    step = 0.3, SensorFrame(22, (2.0,)), (WakeAt(0.55),)

    assert list(Glide(0.5, None, FRAMES, [step]).in_order()) == [*QUIET[:2], step, *QUIET[3:]]
