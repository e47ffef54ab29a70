"""What has passed without the engine is reported in the order of time."""

from __future__ import annotations

from pirate_sm.engine.gliding.glided import Glide
from pirate_sm.model.effects import WakeAt
from pirate_sm.model.events import SensorFrame, Tick
from pirate_sm.model.frame_block import FrameBlock
from pirate_sm.runtime.quiet_time import parts_of

ROWS = [[float(number)] for number in range(5)]
FRAMES = FrameBlock([0.1, 0.2, 0.3, 0.4, 0.5], [22, 23, 22, 23, 22], ROWS, {22: 1, 23: 1})


def test_another_step_stands_between_the_frames_before_and_after_it() -> None:
    step = 0.25, Tick(), (WakeAt(0.5),)
    parts = list(parts_of(Glide(0.5, None, FRAMES, [step])))

    assert [(list(part.frames.times_s), part.step) for part in parts] == [
        ([0.1, 0.2], step),
        ([0.3, 0.4, 0.5], None),
    ]


def test_a_step_of_a_frame_stands_in_its_place() -> None:
    step = 0.3, SensorFrame(22, (2.0,)), (WakeAt(0.55),)
    parts = list(parts_of(Glide(0.5, None, FRAMES, [step])))

    assert [(list(part.frames.times_s), part.step) for part in parts] == [
        ([0.1, 0.2], step),
        ([0.4, 0.5], None),
    ]
