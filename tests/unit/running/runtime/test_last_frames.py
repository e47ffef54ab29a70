"""The last frame of each board is known, whether it came alone or in a block."""

from __future__ import annotations

from pirate_sm.core.events import FrameBlock, SensorFrame
from pirate_sm.running.runtime.pump import LastFrames

BLOCK = FrameBlock(
    (1.0, 2.0, 3.0), (7, 8, 7), ((1.0, 2.0, 0.0), (3.0, 4.0, 5.0), (6.0, 7.0, 0.0)), {7: 2, 8: 3}
)


def test_the_last_frame_of_a_block_replaces_an_earlier_one() -> None:
    last = LastFrames()
    last.hear(SensorFrame(7, (0.0, 0.0)))
    last.hear_block(BLOCK)

    assert last.frames() == (SensorFrame(7, (6.0, 7.0)), SensorFrame(8, (3.0, 4.0, 5.0)))


def test_a_frame_replaces_one_of_a_block() -> None:
    last = LastFrames()
    last.hear_block(BLOCK)
    last.hear(SensorFrame(8, (9.0,)))

    assert set(last.frames()) == {SensorFrame(7, (6.0, 7.0)), SensorFrame(8, (9.0,))}


def test_a_block_gives_its_frames_with_their_times() -> None:
    assert list(BLOCK.frames()) == [
        (1.0, SensorFrame(7, (1.0, 2.0))),
        (2.0, SensorFrame(8, (3.0, 4.0, 5.0))),
        (3.0, SensorFrame(7, (6.0, 7.0))),
    ]
