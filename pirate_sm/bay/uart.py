"""The serial line between host and firmware: bytes take time, and a full ring loses them.

A byte takes ten bits, so the line carries baud/10 bytes per second each way.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

# Rounding must not lose a byte that ends just now.
_SLACK = 1e-6


@dataclass(slots=True)
class _Run:
    """Bytes that follow one another without a gap; the first is complete one byte after."""

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
        bytes_per_s: What the line carries.
        ring: How many bytes wait for the firmware; those that come to a full ring are lost. None
            for a ring without an end.

    Attributes:
        lost: How many bytes came to a full ring.
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
        """Drop what has come until now."""
        lost = self.lost
        self.read(now_s)
        self.lost = lost


class Outlet(_Way):
    """The firmware's send ring and the line to the host.

    A write that finds the ring full waits, as the firmware's does, until it has put in its last
    byte: while the line is busy the firmware stands still.

    Args:
        bytes_per_s: What the line carries.
        ring: How many bytes wait for the line.
    """

    def __init__(self, bytes_per_s: float, ring: int) -> None:
        super().__init__(bytes_per_s)
        self._ring_s = ring / bytes_per_s
        self._line_free_s = -math.inf

    def write(self, size: int, now_s: float) -> tuple[float, float]:
        """Put so many bytes into the ring.

        Returns:
            When the first of them goes onto the line, and when the write returns.
        """
        start = max(self._line_free_s, now_s)
        self._line_free_s = start + size / self._rate
        return start, max(now_s, self._line_free_s - self._ring_s)

    def collect(self, now_s: float) -> bytes:
        """Return what has reached the host since the last call."""
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
        """Drop what is on its way: nobody will read it."""
        self._runs.clear()

    @property
    def due_s(self) -> float:
        """When the frame on the line has reached the host; infinite for a quiet line."""
        if not self._runs:
            return math.inf
        run = self._runs[0]
        return run.start_s + len(run.data) / self._rate

    def cut(self, now_s: float) -> None:
        """Drop what has not reached the host by now: the firmware has started again."""
        kept: deque[_Run] = deque()
        for run in self._runs:
            there = self._arrived(run, now_s)
            if there > run.taken:
                run.data = run.data[:there]
                kept.append(run)
        self._runs = kept
        self._line_free_s = self._end_s = now_s
