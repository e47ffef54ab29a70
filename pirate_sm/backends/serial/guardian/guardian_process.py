"""Start a guardian in a process of its own, exchange notes with it, and end or leave it."""

from __future__ import annotations

import select
import socket
import subprocess
import sys

from pirate_sm.backends.serial.guardian.notes import Note, NoteReader

_LEAVES_WITHIN_S = 2.0
_MOST_BYTES = 65536
_MODULE = "pirate_sm.backends.serial.guardian.process"

_left: list[subprocess.Popen[bytes]] = []
"""Guardians that go on without us: Python complains about processes that nobody waits for."""


class GuardianProcess:
    """A guardian's process and the pipe to it.

    Notes that are sent before it starts wait in the pipe.

    Args:
        patience_s: A note that the pipe does not take for this long raises ``TimeoutError``.
    """

    def __init__(self, patience_s: float) -> None:
        self._pipe, self._theirs = socket.socketpair()
        self._patience_s = patience_s
        self._process: subprocess.Popen[bytes] | None = None
        self._reader = NoteReader()

    @property
    def pid(self) -> int | None:
        """Number of the process; None before it has started."""
        return self._process.pid if self._process is not None else None

    def start(self, *arguments: str) -> None:
        """Start the process with these arguments after the number of its end of the pipe."""
        with self._theirs as theirs:
            # In a session of its own, without any stream of ours: the terminal's Ctrl-C and
            # hang-up are not for it, and nobody who reads our output waits for it.
            self._process = subprocess.Popen(
                [sys.executable, "-m", _MODULE, str(theirs.fileno()), *arguments],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        self._pipe.settimeout(self._patience_s)

    def send(self, note: Note) -> None:
        """Put a note into the pipe.

        Raises:
            OSError: The guardian is gone; a ``TimeoutError`` where it reads nothing.
        """
        self._pipe.sendall(note.to_bytes())

    def receive(self, within_s: float) -> list[Note] | None:
        """Return the notes that come within this time, the first at once; None: it is gone."""
        ready, _, _ = select.select([self._pipe], [], [], max(0.0, within_s))
        if not ready:
            return []
        try:
            data = self._pipe.recv(_MOST_BYTES)
        except OSError:
            data = b""
        return list(self._reader.feed(data)) if data else None

    def hang_up(self) -> bool:
        """Close the pipe; return whether the guardian has ended."""
        self._pipe.close()
        if self._process is not None:
            try:
                self._process.wait(_LEAVES_WITHIN_S)
            except subprocess.TimeoutExpired:
                return False
        return True

    def kill(self) -> None:
        """Kill the guardian, so that it writes nothing more, and close the pipe."""
        if self._process is not None:
            self._process.kill()
        self.hang_up()

    def leave(self) -> None:
        """Let the guardian go on by itself."""
        if self._process is not None:
            _left.append(self._process)
