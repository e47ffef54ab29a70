"""A port to an emulated device in virtual time, with the guardian's decisions."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import inf
from typing import Protocol

from pirate_sm.robot.backends.serial.guardian.guard import Guard
from pirate_sm.robot.backends.serial.guardian.guard_actions import Action, Reopen, ToPort, ToRunner
from pirate_sm.robot.backends.serial.guardian.notes import Instructions, Note, NoteKind
from pirate_sm.robot.backends.serial.link.wanted_topics import Wanted
from pirate_sm.robot.backends.serial.ports.protocol import PortLostError

_EPOCH_S = 1.7e9


class Device(Protocol):
    """The emulated device; calls come in order of time."""

    @property
    def due_s(self) -> float:
        """When it may send something, if it receives nothing."""
        ...

    def open(self, now_s: float) -> None:
        """Handle that the host has opened the port."""
        ...

    def close(self, now_s: float) -> None:
        """Handle that the host has closed the port."""
        ...

    def receive(self, data: bytes, now_s: float) -> None:
        """Take in bytes that the host has written in one call."""
        ...

    def advance(self, now_s: float) -> bytes:
        """Return what the host has received since the last call."""
        ...


class VirtualPort:
    """A port whose guardian and device run in this process, in one virtual time.

    Args:
        device: The emulated device.
        silence_s: After this silence of the runner the guardian acts; infinite for no guardian.
        wanted: The robot's topics, for which the guardian asks after the cable was unplugged.

    Attributes:
        device: The emulated device.
        written: Time and bytes of each writing to the device.
        plugged: Whether the cable is plugged in.
    """

    name = "virtual"
    epoch_s = _EPOCH_S

    def __init__(
        self, device: Device, silence_s: float = inf, wanted: Sequence[Wanted] = ()
    ) -> None:
        self.device = device
        self._silence_s, self._wanted = silence_s, tuple(wanted)
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
        """Open the port if the cable is plugged in; return whether it is."""
        self._notice_cable()
        if self.plugged and not self._connected:
            self.open()
        return self.plugged

    def write(self, data: bytes) -> None:
        """Put the bytes on the device's line, unless the guardian is acting."""
        self._need_cable()
        self._do(self._guard.hear(Note(NoteKind.WRITE, data), self._now_s))

    def read(self, until_s: float) -> bytes:
        """Return received bytes as soon as there are any."""
        self._need_cable()
        self._run(until_s, stop_at_data=True)
        return self._data.popleft() if self._data else b""

    def wait(self, until_s: float) -> None:
        """Let time pass until then; bytes received meanwhile stay readable."""
        self._run(until_s, stop_at_data=False)

    def beat(self, safe_frame: bytes) -> None:
        """Give the guardian a sign of life and the safe frame."""
        self._do(self._guard.hear(Note(NoteKind.BEAT, safe_frame), self._now_s))
        self._need_cable()  # a real guardian without a port reports this too

    def overruled(self) -> bool:
        """Return whether the guardian has acted; from now on it relays again."""
        overruled, self._overruled = self._overruled, False
        if overruled:
            self._do(self._guard.hear(Note(NoteKind.HEED), self._now_s))
        return overruled

    def remark(self) -> str:
        """Return an empty text: no other run can have had this port."""
        return ""

    def close(self, stopped: bool = False) -> None:
        """Let written bytes arrive; a guardian that stays acts while :meth:`wait` runs."""
        if not stopped:
            self._do(self._guard.runner_gone(self._now_s))
        self.wait(self._now_s + 0.1)
        if stopped or self._guard.confirmed or not self._guard.payload:
            self.device.close(self._now_s)

    def die(self, until_s: float) -> None:
        """Kill the runner, and give the guardian until then to act."""
        self._do(self._guard.runner_gone(self._now_s))
        self.wait(until_s)

    def abandon(self) -> None:
        """Kill the runner and the guardian: nobody writes any more."""
        self._guard = Guard(Instructions(inf, ()), _EPOCH_S)
        self.device.close(self._now_s)

    def next_port(self) -> VirtualPort:
        """Return the port of another program on the same device, at the same time."""
        port = VirtualPort(self.device, self._silence_s, self._wanted)
        port._now_s = self._now_s
        return port

    def _notice_cable(self) -> None:
        """Report to the guardian that the cable was unplugged."""
        self.now()  # the cable may be scheduled to be unplugged
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
            elif isinstance(action, ToRunner) and action.note.kind == NoteKind.DATA:
                self._data.append(action.note.body)
            elif isinstance(action, ToRunner):
                self._overruled |= action.note.kind == NoteKind.OVERRULED
            elif isinstance(action, Reopen) and self.plugged:
                self.device.open(self._now_s)
                self._connected = True
                self._do(self._guard.opened(self._now_s))
