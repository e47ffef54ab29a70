"""Start a guardian in its own process, exchange notes with it, and end or leave it."""

from __future__ import annotations

import select
import socket
import subprocess
import sys

from pirate_sm.robot.backends.serial.guardian.notes import Note, NoteReader

_LEAVES_WITHIN_S = 2.0
_MOST_BYTES = 65536
_MODULE = "pirate_sm.robot.backends.serial.guardian.process"

_left: list[subprocess.Popen[bytes]] = []
"""Guardians left running. Python warns about child processes that are garbage-collected."""


class GuardianProcess:
    """The guardian's process and the pipe to it.

    Notes sent before the process starts wait in the pipe.

    Args:
        patience_s: Sending raises ``TimeoutError`` if the pipe takes nothing for this long.
    """

    def __init__(self, patience_s: float) -> None:
        self._pipe, self._theirs = socket.socketpair()
        self._patience_s = patience_s
        self._process: subprocess.Popen[bytes] | None = None
        self._reader = NoteReader()

    @property
    def pid(self) -> int | None:
        """Process id; None before the process has started."""
        return self._process.pid if self._process is not None else None

    def start(self, *arguments: str) -> None:
        """Start the process with its pipe's descriptor and these arguments."""
        with self._theirs as theirs:
            # A session of its own and no stream of ours: the terminal's Ctrl-C and hang-up do not
            # reach it, and a reader of our output does not wait for it.
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
        """Send a note through the pipe.

        Raises:
            OSError: The guardian is gone; ``TimeoutError`` if it does not read.
        """
        self._pipe.sendall(note.to_bytes())

    def receive(self, within_s: float) -> list[Note] | None:
        """Return notes received within this time, without delay; None if the guardian is gone."""
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
        """Let the guardian go on without this program."""
        if self._process is not None:
            _left.append(self._process)
