"""Limits the rate of writing to a microcontroller with a small receive ring."""

from __future__ import annotations

from collections import deque

RING_BYTES = 64
"""Receive ring of the Arduino Mega's serial port."""

_READ_WITHIN_S = 0.020
"""A healthy device reads its ring this often; a frame must be complete by then too."""

_BITS_PER_BYTE = 10
"""Bits of a byte on the wire: start bit, eight data bits, stop bit."""

_SETPOINT_SHARE = 1 / 6
"""Share of the line for arrays of setpoints: 20 per second at 57,600 baud and 18 slots."""


class Throttle:
    """Keeps the bytes under way to the device below its ring, whatever the device does meanwhile.

    Args:
        baud: Baud rate of the line.
    """

    def __init__(self, baud: int) -> None:
        self._byte_s = _BITS_PER_BYTE / baud
        self._written: deque[tuple[float, int]] = deque()
        self._recent = 0

    def free_s(self, size: int, now: float) -> float:
        """Return when a frame of this size may be written; ``now`` if at once."""
        self._forget(now)
        excess = self._recent + min(size, RING_BYTES) - RING_BYTES
        free = now
        for at_s, written in self._written:
            if excess <= 0:
                break
            excess -= written
            free = at_s
        return free

    def wrote(self, size: int, now: float, busy_s: float = 0.0) -> None:
        """Count this many bytes as written.

        Args:
            size: Number of bytes.
            now: The time.
            busy_s: How long the device reads nothing after these bytes.
        """
        arrives = max(now, self._written[-1][0] - _READ_WITHIN_S if self._written else now)
        self._written.append((arrives + size * self._byte_s + _READ_WITHIN_S + busy_s, size))
        self._recent += size

    def spacing_s(self, size: int) -> float:
        """Return the least time between two arrays with frames of this size, s."""
        return size * self._byte_s / _SETPOINT_SHARE

    def _forget(self, now: float) -> None:
        while self._written and self._written[0][0] <= now:
            self._recent -= self._written.popleft()[1]
