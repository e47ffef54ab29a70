"""Moves bytes between an exchange and its port, and reopens a lost port."""

from __future__ import annotations

from math import inf

from pirate_sm.core.events import BuiltInFault, Event
from pirate_sm.robot.backends.serial.link.exchange import Exchange
from pirate_sm.robot.backends.serial.ports.protocol import Port, PortLostError

_REOPEN_EVERY_S = 0.5
_SAMPLE_BYTES = 4096


class LinkPump:
    """Writes due bytes to the port and passes received ones to the exchange.

    Args:
        port: The robot's port.
        exchange: The driver of the link.

    Attributes:
        sample: The last bytes received before the topics were known, for error messages.
    """

    def __init__(self, port: Port, exchange: Exchange) -> None:
        self.sample = b""
        self._port = port
        self._exchange = exchange
        self._faults: list[Event] = []
        self._lost_s = inf
        self._retry_s = -inf

    @property
    def lost(self) -> bool:
        """Whether the port has gone."""
        return self._lost_s < inf

    def take(self) -> list[Event]:
        """Return the events since the last call, oldest first."""
        faults, self._faults = self._faults, []
        return [*faults, *self._exchange.take()]

    def turn(self, until_s: float) -> None:
        """Write everything that is due, and take in what comes by ``until_s``."""
        port, exchange = self._port, self._exchange
        if self.lost:
            self._retry(port.now())
        now = port.now()
        able = not self.lost
        try:
            while data := exchange.write(now, able):
                port.beat(exchange.guarded_frame())  # before the robot moves
                port.write(data)
            port.beat(exchange.guarded_frame())
            data = port.read(min(until_s, self._due_s(now))) if able else b""
        except PortLostError as error:
            self._lose(str(error))
        if self.lost:
            port.wait(min(until_s, self._due_s(now)))
            return
        if data:
            if not exchange.conversation.known:
                self.sample = (self.sample + data)[-_SAMPLE_BYTES:]
            exchange.receive(data, port.now())
        self._heed_guardian()

    def put(self, data: bytes) -> None:
        """Write the bytes as soon as the device's ring has room for them."""
        port, exchange = self._port, self._exchange
        free_s = exchange.room_s(len(data), port.now())
        while port.now() < free_s:
            port.wait(free_s)
        port.write(data)
        exchange.wrote(len(data), port.now())

    def _heed_guardian(self) -> None:
        """Report a fault if the guardian has stopped the robot instead of this program."""
        try:
            overruled = self._port.overruled()
        except PortLostError as error:
            self._lose(str(error))
            return
        if overruled:
            message = "this program stood still for too long, the guardian of the port has stopped"
            self._faults.append(BuiltInFault.RUNNER_STALLED.report(f"{message} the robot"))

    def _due_s(self, now: float) -> float:
        return self._retry_s if self.lost else self._exchange.due_s(now)

    def _lose(self, reason: str) -> None:
        now = self._port.now()
        if not self.lost:
            self._lost_s = now
            self._retry_s = now + _REOPEN_EVERY_S
            self._exchange.lost(reason, now)

    def _retry(self, now: float) -> None:
        """Try to reopen a lost port; the exchange then asks for topics and sends the array."""
        if now < self._retry_s:
            return
        self._retry_s = now + _REOPEN_EVERY_S
        if self._port.reopen():
            self._lost_s = inf
            self._exchange.connected(self._port.now())
