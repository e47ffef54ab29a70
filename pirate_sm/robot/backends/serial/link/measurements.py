"""Turns State messages of either layout into one sensor frame for each board."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan

from pirate_sm.core.events import SensorFrame
from pirate_sm.robot.rosserial.state_messages import StateReading


class Measurements:
    """Collects readings until they make the frame of a board.

    If a message carries one value, a board is reported when all its values have come. A lost value
    is replaced by the previous one when the next round begins.

    Args:
        channels: Number of channels of each board that reports.

    Attributes:
        strange: Readings of unknown boards or channels.
    """

    def __init__(self, channels: Mapping[int, int]) -> None:
        self._channels = dict(channels)
        self._values = {board: [nan] * count for board, count in channels.items()}
        self._fresh: dict[int, set[int]] = {board: set() for board in channels}
        self.strange = 0

    def take(self, reading: StateReading) -> SensorFrame | None:
        """Return the frame that this reading completes; None if it completes none."""
        board, channel, values = reading
        count = self._channels.get(board)
        if count is None or (len(values) < count if channel < 0 else channel >= count):
            self.strange += 1
            return None
        if channel < 0:
            return SensorFrame(board, values[:count])
        held, fresh = self._values[board], self._fresh[board]
        lapped = SensorFrame(board, tuple(held)) if channel in fresh else None
        if lapped is not None:
            fresh.clear()
        held[channel] = values[0]
        fresh.add(channel)
        if len(fresh) < count:
            return lapped
        fresh.clear()
        return SensorFrame(board, tuple(held))
