"""A small process that owns the serial port: ``python -m pirate_sm.backends.pico.guardian``.

It relays between the port and the runner and keeps the runner's safe frame at hand. Whatever
happens to the runner, the pipe closes or the heartbeat stops, and the safe frame goes out.
"""

from __future__ import annotations

import os
import select
import signal
import socket
import sys
from contextlib import suppress
from math import inf
from types import FrameType

from pirate_sm.backends.pico.guarding import (
    Action,
    Finish,
    Guard,
    Kind,
    Note,
    NoteReader,
    Reopen,
    ToPort,
    ToRunner,
)
from pirate_sm.backends.pico.port import PortLostError
from pirate_sm.backends.pico.serial_port import SerialPort
from pirate_sm.errors import BackendError

_MOST_BYTES = 65536
_POLL_S = 0.005
"""For ports that have no descriptor to wait for."""

_MOST_WAITING = 16384
"""Bytes kept for a runner that stands still: some seconds of the line."""


class Guardian:
    """The guard with its hands on a port and a pipe.

    Args:
        port: The serial port.
        pipe: To the runner.
        guard: What decides.
    """

    def __init__(self, port: SerialPort, pipe: socket.socket, guard: Guard) -> None:
        self._port = port
        self._pipe: socket.socket | None = pipe
        pipe.setblocking(False)  # whoever waits for a runner guards nothing
        self._waiting = bytearray()
        self._guard = guard
        self._reader = NoteReader()
        self._plugged = False
        self._done = False
        self._told_to_end, self._teller = os.pipe()
        os.set_blocking(self._teller, False)

    def serve(self) -> None:
        """There is nothing left to guard, and the port is free."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, self._tell)
        try:
            self._open()
            while not self._done:
                self._turn()
        finally:
            self._port.close()

    def _tell(self, number: int, frame: FrameType | None) -> None:
        with suppress(OSError):
            os.write(self._teller, b"!")

    def _turn(self) -> None:
        guard, now = self._guard, self._port.now
        for source in self._wait():
            if source == self._told_to_end:
                os.read(self._told_to_end, 64)
                self._do(guard.bereave(now()))
            elif self._pipe is not None and source == self._pipe.fileno():
                self._hear()
        if self._plugged:
            try:
                data = self._port.read(now())
            except PortLostError as error:
                self._lose(error)
            else:
                if data:
                    self._do(guard.receive(data, now()))
        self._do(guard.tick(now()))

    def _wait(self) -> list[int]:
        """What there is to be read, besides the port."""
        sources = [self._told_to_end]
        if self._pipe is not None:
            sources.append(self._pipe.fileno())
        wait_s = max(0.0, self._guard.due_s - self._port.now())
        if self._plugged:
            descriptor = self._port.descriptor
            if descriptor < 0:
                wait_s = min(wait_s, _POLL_S)
            else:
                sources.append(descriptor)
        full = [self._pipe] if self._pipe is not None and self._waiting else []
        readable, writable, _ = select.select(sources, full, [], None if wait_s == inf else wait_s)
        if writable:
            self._push()
        return readable

    def _hear(self) -> None:
        assert self._pipe is not None  # it has just been readable
        try:
            data = self._pipe.recv(_MOST_BYTES)
            notes = self._reader.feed(data)
        except BlockingIOError:
            return
        except (OSError, ValueError):
            data, notes = b"", []
        for note in notes:
            self._do(self._guard.hear(note, self._port.now()))
        if not data:
            self._orphan()

    def _orphan(self) -> None:
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None
            self._waiting.clear()
            self._do(self._guard.bereave(self._port.now()))

    def _do(self, actions: list[Action]) -> None:
        for action in actions:
            if isinstance(action, ToPort):
                self._write(action.data)
            elif isinstance(action, ToRunner):
                self._say(action.note)
            elif isinstance(action, Reopen):
                self._open()
            elif isinstance(action, Finish):
                self._done = True

    def _write(self, data: bytes) -> None:
        if self._plugged:
            try:
                self._port.write(data)
            except PortLostError as error:
                self._lose(error)

    def _say(self, note: Note) -> None:
        """The runner is told as soon as it listens; of the port's bytes it is kept only so many."""
        if self._pipe is None or (note.kind == Kind.DATA and len(self._waiting) > _MOST_WAITING):
            return
        self._waiting += note.to_bytes()
        self._push()

    def _push(self) -> None:
        if self._pipe is None:
            return
        try:
            del self._waiting[: self._pipe.send(self._waiting)]
        except BlockingIOError:
            return  # it stands still
        except OSError:
            self._orphan()

    def _open(self) -> None:
        try:
            self._port.close()
            self._port.open()
            self._plugged = True
            self._say(Note(Kind.OPENED))
        except BackendError as error:
            self._say(Note(Kind.REFUSED, str(error).encode()))

    def _lose(self, error: PortLostError) -> None:
        self._plugged = False
        self._say(Note(Kind.LOST, str(error).encode()))
        if self._pipe is None:
            self._done = True


def main(arguments: list[str]) -> None:
    """The port has been guarded until nobody needed it any more.

    Args:
        arguments: Descriptor of the pipe, port, baud, seconds within which the runner is heard.
    """
    descriptor, url, baud, silence_s = arguments
    pipe = socket.socket(fileno=int(descriptor))
    Guardian(SerialPort(url, int(baud)), pipe, Guard(float(silence_s))).serve()


if __name__ == "__main__":
    main(sys.argv[1:])
