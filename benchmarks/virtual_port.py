"""A port to an emulated device in virtual time, with the guardian's decisions."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import inf
from typing import Protocol

from pirate_sm.backends.serial.guardian.guard import Guard
from pirate_sm.backends.serial.guardian.guard_actions import Action, Reopen, ToPort, ToRunner
from pirate_sm.backends.serial.guardian.notes import Instructions, Kind, Note
from pirate_sm.backends.serial.link.wanted_topics import Wanted
from pirate_sm.backends.serial.ports.protocol import PortLostError

_EPOCH_S = 1.7e9


class Device(Protocol):
    """The device at the other end; calls come in order of time."""

    @property
    def due_s(self) -> float:
        """When something may come from it, if it is left alone."""
        ...

    def open(self, now_s: float) -> None:
        """Note that its port has been opened."""
        ...

    def close(self, now_s: float) -> None:
        """Note that its port has been closed."""
        ...

    def receive(self, data: bytes, now_s: float) -> None:
        """Take in bytes that the host has written in one call."""
        ...

    def advance(self, now_s: float) -> bytes:
        """Return what has come to the host since the last call."""
        ...


class VirtualPort:
    """A port whose guardian and device run in this process, in one virtual time.

    Args:
        device: What is at the other end.
        silence_s: The guardian's patience with the runner; infinite: there is none.
        wanted: The robot's topics, for which the guardian asks after the cable was out.

    Attributes:
        device: As given.
        written: When something was written to the device, and what.
        plugged: Whether the cable is in.
    """

    name = "virtual"
    epoch_s = _EPOCH_S

    def __init__(
        self, device: Device, silence_s: float = inf, wanted: Sequence[Wanted] = ()
    ) -> None:
        self.device = device
        self._guard = Guard(Instructions(silence_s, tuple(wanted)), _EPOCH_S)
        self._now_s = 0.0
        self._data: deque[bytes] = deque()
        self._overruled = False
        self._connected = False
        self.written: list[tuple[float, bytes]] = []
        self.plugged = True

    def now(self) -> float:
        """Return the device's time, s."""
        return self._now_s

    def open(self) -> None:
        """Open the port."""
        self._do([Reopen()])

    def reopen(self) -> bool:
        """Open the port if the cable is in again; return whether it is."""
        self._notice_cable()
        if self.plugged and not self._connected:
            self.open()
        return self.plugged

    def write(self, data: bytes) -> None:
        """Put the bytes on the device's line, unless the guardian is acting."""
        self._need_cable()
        self._do(self._guard.hear(Note(Kind.WRITE, data), self._now_s))

    def read(self, until_s: float) -> bytes:
        """Return what has come, as soon as anything has."""
        self._need_cable()
        self._run(until_s, stop_at_data=True)
        return self._data.popleft() if self._data else b""

    def wait(self, until_s: float) -> None:
        """Pass the time until then; what comes meanwhile is still to be read."""
        self._run(until_s, stop_at_data=False)

    def beat(self, safe_frame: bytes) -> None:
        """Give the guardian a sign of life and the safe frame."""
        self._do(self._guard.hear(Note(Kind.BEAT, safe_frame), self._now_s))
        self._need_cable()  # as one hears from a guardian without a port

    def overruled(self) -> bool:
        """Return whether the guardian has acted; it relays again from now on."""
        overruled, self._overruled = self._overruled, False
        if overruled:
            self._do(self._guard.hear(Note(Kind.HEED), self._now_s))
        return overruled

    def remark(self) -> str:
        """Return nothing: nobody else has had this one."""
        return ""

    def close(self, stopped: bool = False) -> None:
        """Let what was written arrive; a guardian that stays acts while :meth:`wait` goes on."""
        if not stopped:
            self._do(self._guard.bereave(self._now_s))
        self.wait(self._now_s + 0.1)
        if stopped or self._guard.confirmed or not self._guard.payload:
            self.device.close(self._now_s)

    def die(self, until_s: float) -> None:
        """Kill the runner, and give the guardian until then to act."""
        self._do(self._guard.bereave(self._now_s))
        self.wait(until_s)

    def _notice_cable(self) -> None:
        """Tell the guardian that the cable was pulled."""
        self.now()  # a cable may be pulled at a certain time
        if self._connected and not self.plugged:
            self._connected = False
            self._do(self._guard.lost("the cable is out", self._now_s))

    def _need_cable(self) -> None:
        self._notice_cable()
        if not self.plugged:
            raise PortLostError("the cable is out")

    def _run(self, until_s: float, stop_at_data: bool) -> None:
        until_s = max(until_s, self._now_s)
        if until_s == inf and min(self.device.due_s, self._guard.due_s) == inf:
            raise PortLostError("nothing will ever come")
        while not (stop_at_data and self._data):
            due_s = min(self.device.due_s, self._guard.due_s)
            self._now_s = min(max(due_s, self._now_s), until_s)
            self._notice_cable()
            data = self.device.advance(self._now_s)
            if data and self.plugged:
                self._do(self._guard.receive(data, self._now_s))
            self._do(self._guard.tick(self._now_s))
            if self._now_s >= until_s:
                return

    def _do(self, actions: list[Action]) -> None:
        for action in actions:
            if isinstance(action, ToPort) and self.plugged:
                self.written.append((self._now_s, action.data))
                self.device.receive(action.data, self._now_s)
            elif isinstance(action, ToRunner) and action.note.kind == Kind.DATA:
                self._data.append(action.note.body)
            elif isinstance(action, ToRunner):
                self._overruled |= action.note.kind == Kind.OVERRULED
            elif isinstance(action, Reopen) and self.plugged:
                self.device.open(self._now_s)
                self._connected = True
                self._do(self._guard.opened(self._now_s))
