"""The serial line between host and firmware, with its byte rate, loss, damage and delay."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from pirate_sm.robot.rosserial.frames import SerialFrame, encode
from pirate_sm.simulation.acting_defect import Loss
from pirate_sm.simulation.bay.bay_defects import Corruption, Switches

# --- bytes and rings -----------------------------------------------------------------------------
# A byte takes ten bits, so the line carries baud/10 bytes per second each way.


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


# --- loss, damage and delay ----------------------------------------------------------------------


_SEND_RING = 64
_BITS_PER_BYTE = 10


class SerialLine:
    """Both directions of the serial line, with loss, damage and delay.

    Args:
        baud: Baud rate of the line.
        switches: The defects to emulate.
        rng: Random numbers.

    Attributes:
        connected: Whether a host has the port open; if not, sent frames are lost.
    """

    def __init__(self, baud: int, switches: Switches, rng: np.random.Generator) -> None:
        rate = baud / _BITS_PER_BYTE
        chances = rng.spawn(6)
        self.connected = False
        self._inlet = Inlet(rate, switches.ring)
        self._outlet = Outlet(rate, _SEND_RING)
        self._loss_in = Loss(switches.loss_in, switches.never_two, chances[0])
        self._loss_out = Loss(switches.loss_out, switches.never_two, chances[1])
        self._damage_in = Corruption(switches.corruption, chances[2])
        self._damage_out = Corruption(switches.corruption, chances[3])
        self._delay_s, self._jitter_s = switches.delay_s, switches.jitter_s
        self._cut_s = switches.cut_at_s
        self._late_in, self._late_out = chances[4], chances[5]

    @property
    def overrun(self) -> int:
        """How many bytes of the host were lost to a full ring."""
        return self._inlet.lost

    @property
    def due_s(self) -> float:
        """When the frame under way reaches the host, s."""
        return self._outlet.due_s

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that the host has written in one call."""
        if now_s < self._cut_s:
            self._inlet.send(self._damage_in.damage(data), now_s + self._late(self._late_in))

    def read(self, now_s: float) -> tuple[list[tuple[int, float]], bool]:
        """Return the waiting bytes with their times of arrival, and whether others were lost."""
        lost = self._inlet.lost
        return self._inlet.read(now_s), self._inlet.lost > lost

    def lets_in(self, topic: int) -> bool:
        """Return whether a received frame gets past the emulated loss."""
        return self._loss_in.arrives(topic)

    def write(self, frame: SerialFrame, now_s: float) -> float:
        """Put the frame on the line; return when the firmware's write returns."""
        data = encode(*frame)
        start, done = self._outlet.write(len(data), now_s)
        if self.connected and now_s < self._cut_s and self._loss_out.arrives(frame.topic):
            late = self._late(self._late_out)
            self._outlet.send(self._damage_out.damage(data), start + late)
        return done

    def collect(self, now_s: float) -> bytes:
        """Return the bytes that have reached the host since the last call."""
        return self._outlet.collect(now_s)

    def hang_up(self) -> None:
        """Drop the frames under way to the host, because no host has the port open."""
        self.connected = False
        self._outlet.discard()

    def restart(self, now_s: float) -> None:
        """Empty the firmware's rings."""
        self._outlet.cut(now_s)
        self._inlet.clear(now_s)

    def ignore(self, now_s: float) -> None:
        """Drop everything received until now."""
        self._inlet.clear(now_s)

    def _late(self, rng: np.random.Generator) -> float:
        if self._jitter_s == 0.0:
            return self._delay_s
        return self._delay_s + float(rng.uniform(0.0, self._jitter_s))
