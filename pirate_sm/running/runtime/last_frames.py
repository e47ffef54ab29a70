"""The last frame of each board that a backend has reported."""

from __future__ import annotations

from pirate_sm.core.events import FrameBlock, SensorFrame


class LastFrames:
    """Remembers the last frame of each board; one of a block is made when it is needed."""

    def __init__(self) -> None:
        self._last: dict[int, SensorFrame | tuple[FrameBlock, int]] = {}

    def hear(self, frame: SensorFrame) -> None:
        """Remember a frame."""
        self._last[frame.board] = frame

    def hear_block(self, block: FrameBlock) -> None:
        """Remember the frames of a block."""
        for at, board in enumerate(block.boards):
            self._last[board] = block, at

    def frames(self) -> tuple[SensorFrame, ...]:
        """Return the last frame of each board."""
        return tuple(
            each if isinstance(each, SensorFrame) else each[0].frame(each[1])
            for each in self._last.values()
        )
