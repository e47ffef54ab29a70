"""The serial line with its loss, damage and delay."""

from __future__ import annotations

import numpy as np

from pirate_sm.robot.rosserial.frames import SerialFrame, encode
from pirate_sm.simulation.bay.switches import Corruption, Switches
from pirate_sm.simulation.bay.uart import Inlet, Outlet
from pirate_sm.simulation.loss import Loss

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
