"""The process that owns the serial port, started with ``python -m`` and the name of this module.

It relays between the port and the runner and keeps the runner's safe array. If the pipe closes or
the heartbeat stops, it writes that array until the robot has confirmed it, and reopens the port if
that went away.

Signals: SIGTERM ends the runner's use of the port; a guardian without a runner ends. SIGUSR1 makes
a guardian without a runner give the port up to a new run.
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

from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.serial.guardian.guard import (
    Action,
    EndGuardian,
    Guard,
    Instructions,
    Note,
    NoteKind,
    NoteReader,
    Reopen,
    ToPort,
    ToRunner,
)
from pirate_sm.robot.backends.serial.guardian.takeover import LeftBehind, Registration
from pirate_sm.robot.backends.serial.port import PortLostError
from pirate_sm.robot.backends.serial.serial_port import SerialPort

_MOST_BYTES = 65536
_POLL_S = 0.005
"""Polling interval for ports without a descriptor to wait for."""

_MOST_WAITING = 16384
"""Bytes of the port kept for a runner that does not read: some seconds of the line."""

STOPPED, GAVE_UP = 0, 1
"""Exit codes: the robot has confirmed its stop or needed none; it has not confirmed it."""


class Guardian:
    """Carries out what the guard decides, on a port and a pipe to the runner.

    Args:
        port: The serial port.
        pipe: The pipe to the runner.
        guard: Makes the decisions.
        md5: Checksum of the definition of an array, for a run that takes the port over.
    """

    def __init__(self, port: SerialPort, pipe: socket.socket, guard: Guard, md5: str = "") -> None:
        self._port = port
        self._pipe: socket.socket | None = pipe
        pipe.setblocking(False)  # a guardian must not block on its runner
        self._waiting = bytearray()
        self._guard = guard
        self._md5 = md5
        self._reader = NoteReader()
        self._plugged = False
        self._finish: EndGuardian | None = None
        self._registration: Registration | None = None
        self._signalled, self._signal = os.pipe()
        os.set_blocking(self._signal, False)

    def serve(self) -> int:
        """Guard the port until nobody needs it any more; return the exit code."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, self._note_signal)
        signal.signal(signal.SIGUSR1, self._note_signal)
        try:
            self._open()
            while self._finish is None:
                self._turn()
        finally:
            self._port.close()
            if self._registration is not None:
                self._registration.remove()
        return STOPPED if self._finish.stopped else GAVE_UP

    def _note_signal(self, number: int, frame: FrameType | None) -> None:
        with suppress(OSError):
            os.write(self._signal, bytes((number,)))

    def _turn(self) -> None:
        guard, now = self._guard, self._port.now
        for source in self._wait():
            if source == self._signalled:
                self._heed(os.read(self._signalled, 64))
            elif self._pipe is not None and source == self._pipe.fileno():
                self._hear()
        if self._plugged:
            try:
                data = self._port.read()
            except PortLostError as error:
                self._lose(error)
            else:
                if data:
                    self._do(guard.receive(data, now()))
        self._do(guard.tick(now()))

    def _wait(self) -> list[int]:
        """Return the readable descriptors, besides the port."""
        sources = [self._signalled]
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

    def _heed(self, numbers: bytes) -> None:
        """Handle signals."""
        alone = self._guard.alone
        if alone:  # an operator or a new run wants the port
            self._finish = EndGuardian(stopped=False)
        elif signal.SIGTERM in numbers:
            self._close_pipe()

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
            self._close_pipe()

    def _close_pipe(self) -> None:
        """Close the pipe and let the guard act, because the runner has gone."""
        if self._pipe is None:
            return
        self._pipe.close()
        self._pipe = None
        self._waiting.clear()
        self._do(self._guard.runner_gone(self._port.now()))
        if self._finish is None:
            left = LeftBehind.of(self._port.name, self._md5, self._guard.payload)
            self._registration = Registration(left)

    def _do(self, actions: list[Action]) -> None:
        for action in actions:
            match action:
                case ToPort(data):
                    self._write(data)
                case ToRunner(note):
                    self._queue(note)
                case Reopen():
                    self._open()
                case EndGuardian():
                    self._finish = action

    def _write(self, data: bytes) -> None:
        if self._plugged:
            try:
                self._port.write(data)
            except PortLostError as error:
                self._lose(error)

    def _queue(self, note: Note) -> None:
        """Queue a note for the runner; drop bytes of the port beyond a limit."""
        if self._pipe is None or (
            note.kind == NoteKind.DATA and len(self._waiting) > _MOST_WAITING
        ):
            return
        self._waiting += note.to_bytes()
        self._push()

    def _push(self) -> None:
        if self._pipe is None:
            return
        try:
            del self._waiting[: self._pipe.send(self._waiting)]
        except BlockingIOError:
            return  # the runner does not read
        except OSError:
            self._waiting.clear()  # it has gone; its earlier notes are still to be read

    def _open(self) -> None:
        guard, now = self._guard, self._port.now
        try:
            self._port.open()
        except BackendError as error:
            self._do(guard.refused(str(error), now()))
        else:
            self._plugged = True
            self._do(guard.opened(now()))

    def _lose(self, error: PortLostError) -> None:
        self._plugged = False
        self._do(self._guard.lost(str(error), self._port.now()))


def main(arguments: list[str]) -> int:
    """Guard a port; return the exit code.

    Args:
        arguments: Descriptor of the pipe, port, baud, instructions.
    """
    descriptor, url, baud, text = arguments
    instructions = Instructions.from_json(text)
    pipe = socket.socket(fileno=int(descriptor))
    port = SerialPort(url, int(baud))
    guard = Guard(instructions, port.epoch_s)
    return Guardian(port, pipe, guard, instructions.array_md5).serve()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
