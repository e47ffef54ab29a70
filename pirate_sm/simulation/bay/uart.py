"""The serial line between host and firmware, with its byte rate and its full rings.

A byte takes ten bits, so the line carries baud/10 bytes per second each way.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

# Rounding must not lose a byte that ends at this time.
_SLACK = 1e-6


@dataclass(slots=True)
class _Run:
    """Bytes that follow one another without a gap; the first is complete one byte time later."""

    start_s: float
    data: bytes
    taken: int = 0


class _Way:
    """One direction of the line, with the bytes that are under way."""

    def __init__(self, bytes_per_s: float) -> None:
        self._rate = bytes_per_s
        self._runs: deque[_Run] = deque()
        self._end_s = -math.inf

    def send(self, data: bytes, start_s: float) -> None:
        """Put the bytes on the line from this time on, behind those before them."""
        start = max(self._end_s, start_s)
        self._runs.append(_Run(start, data))
        self._end_s = start + len(data) / self._rate

    def _arrived(self, run: _Run, now_s: float) -> int:
        return min(int((now_s - run.start_s) * self._rate + _SLACK), len(run.data))


class Inlet(_Way):
    """The line from the host, and the ring that the firmware reads from.

    Args:
        bytes_per_s: Rate of the line.
        ring: How many bytes can wait for the firmware; more are lost. None: no limit.

    Attributes:
        lost: Bytes lost to a full ring.
    """

    def __init__(self, bytes_per_s: float, ring: int | None) -> None:
        super().__init__(bytes_per_s)
        self.lost = 0
        self._ring = ring

    def read(self, now_s: float) -> list[tuple[int, float]]:
        """Empty the ring and return its bytes with their times of arrival."""
        found: list[tuple[int, float]] = []
        room = math.inf if self._ring is None else self._ring
        while self._runs:
            run = self._runs[0]
            arrived = self._arrived(run, now_s)
            for index in range(run.taken, arrived):
                if len(found) < room:
                    found.append((run.data[index], run.start_s + (index + 1) / self._rate))
                else:
                    self.lost += 1
            run.taken = max(run.taken, arrived)
            if run.taken < len(run.data):
                break
            self._runs.popleft()
        return found

    def clear(self, now_s: float) -> None:
        """Drop everything received until now."""
        lost = self.lost
        self.read(now_s)
        self.lost = lost


class Outlet(_Way):
    """The firmware's send ring and the line to the host.

    A write to a full ring blocks, as the firmware's does, until its last byte is in the ring. So
    the firmware stands still while the line is busy.

    Args:
        bytes_per_s: Rate of the line.
        ring: How many bytes can wait for the line.
    """

    def __init__(self, bytes_per_s: float, ring: int) -> None:
        super().__init__(bytes_per_s)
        self._ring_s = ring / bytes_per_s
        self._line_free_s = -math.inf

    def write(self, size: int, now_s: float) -> tuple[float, float]:
        """Put this many bytes into the ring.

        Returns:
            When the first byte goes onto the line, and when the write returns.
        """
        start = max(self._line_free_s, now_s)
        self._line_free_s = start + size / self._rate
        return start, max(now_s, self._line_free_s - self._ring_s)

    def collect(self, now_s: float) -> bytes:
        """Return the bytes that have reached the host since the last call."""
        found: list[bytes] = []
        while self._runs:
            run = self._runs[0]
            there = self._arrived(run, now_s)
            if there > run.taken:
                found.append(run.data[run.taken : there])
                run.taken = there
            if run.taken < len(run.data):
                break
            self._runs.popleft()
        return b"".join(found)

    def discard(self) -> None:
        """Drop the bytes under way, because nobody will read them."""
        self._runs.clear()

    @property
    def due_s(self) -> float:
        """When the frame on the line reaches the host; infinite if there is none."""
        if not self._runs:
            return math.inf
        run = self._runs[0]
        return run.start_s + len(run.data) / self._rate

    def cut(self, now_s: float) -> None:
        """Drop the bytes that have not reached the host, because the firmware has restarted."""
        kept: deque[_Run] = deque()
        for run in self._runs:
            there = self._arrived(run, now_s)
            if there > run.taken:
                run.data = run.data[:there]
                kept.append(run)
        self._runs = kept
        self._line_free_s = self._end_s = now_s
