"""A serial port in the hands of a guardian, as the runner sees it."""

from __future__ import annotations

import select
import socket
import subprocess
import sys
import time
from collections import deque
from contextlib import suppress
from math import inf

from pirate_sm.backends.pico.guarding import Kind, Note, NoteReader
from pirate_sm.backends.pico.port import PortLostError
from pirate_sm.errors import BackendError

_BEATS = 6
"""In the time within which one must be heard."""

_STARTS_WITHIN_S = 15.0
_LEAVES_WITHIN_S = 2.0
_MOST_BYTES = 65536
_MODULE = "pirate_sm.backends.pico.guardian"


class GuardedPort:
    """Starts a guardian for a port and speaks through it.

    Args:
        url: A device such as ``/dev/ttyACM0``, or any URL of pyserial.
        baud: Of the line.
        silence_s: The guardian acts when it has not heard us for so long.
    """

    def __init__(self, url: str, baud: int, silence_s: float) -> None:
        self.name = url
        self.epoch_s = time.time() - time.monotonic()
        self._baud = baud
        self._silence_s = silence_s
        self._pipe: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._reader = NoteReader()
        self._data: deque[bytes] = deque()
        self._beat_s = -inf
        self._safe_frame = b""
        self._lost = ""
        self._opened = False
        self._refused = ""
        self._overruled = False

    now = staticmethod(time.monotonic)

    @property
    def guardian_pid(self) -> int | None:
        """Number of the guardian's process; None when there is none."""
        return self._process.pid if self._process is not None else None

    def open(self) -> None:
        """A guardian has the port."""
        self._start()
        give_up_s = self.now() + _STARTS_WITHIN_S
        while not self._opened:
            try:
                self._listen(give_up_s)
            except PortLostError:
                raise BackendError("the guardian of the serial port could not be started") from None
            if self._refused or self.now() >= give_up_s:
                refused = self._refused or "the guardian of the serial port does not answer"
                self._dismiss()
                raise BackendError(refused)

    def _start(self) -> None:
        self._dismiss()
        ours, theirs = socket.socketpair()
        with theirs:
            # A process group of its own: the terminal's Ctrl-C and hang-up are not for it.
            self._process = subprocess.Popen(
                [
                    *(sys.executable, "-m", _MODULE, str(theirs.fileno())),
                    *(self.name, str(self._baud), str(self._silence_s)),
                ],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                start_new_session=True,
            )
        ours.settimeout(self._silence_s)
        self._pipe, self._reader = ours, NoteReader()
        self._data.clear()
        self._opened, self._refused, self._lost, self._overruled = False, "", "", False
        self._beat_s, self._safe_frame = -inf, b""

    def reopen(self) -> bool:
        """Whether the guardian has the port again; without a guardian there is a new one."""
        if self._pipe is None:
            with suppress(BackendError):
                self.open()
            return self._opened and not self._lost
        try:
            self._listen(self.now())
        except PortLostError:
            if self._pipe is None:
                return False
        if self._opened:
            self._lost = ""
            return True
        with suppress(PortLostError):
            self._say(Note(Kind.REOPEN))
        return False

    def write(self, data: bytes) -> None:
        """The guardian has been given the bytes in one piece."""
        self._say(Note(Kind.WRITE, data))

    def read(self, until_s: float) -> bytes:
        """What has come, as soon as anything has."""
        if not self._data:
            self._listen(until_s)
        return self._data.popleft() if self._data else b""

    def wait(self, until_s: float) -> None:
        """It is that time."""
        time.sleep(max(0.0, until_s - self.now()))

    def beat(self, safe_frame: bytes) -> None:
        """The guardian knows that we live, and what to send when we do not."""
        now = self.now()
        if safe_frame != self._safe_frame or now - self._beat_s >= self._silence_s / _BEATS:
            self._beat_s, self._safe_frame = now, safe_frame
            if self._pipe is not None:
                self._say(Note(Kind.BEAT, safe_frame))

    def overruled(self) -> bool:
        """Whether the guardian has acted since this was last asked; it obeys again from now on."""
        overruled, self._overruled = self._overruled, False
        if overruled:
            self._say(Note(Kind.HEED))
            self._beat_s = -inf
        return overruled

    def close(self) -> None:
        """The guardian has let the port go, and ended."""
        with suppress(PortLostError):
            self._say(Note(Kind.LEAVE))
        self._dismiss()

    def _dismiss(self) -> None:
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None
        process, self._process = self._process, None
        if process is not None:
            try:
                process.wait(_LEAVES_WITHIN_S)
            except subprocess.TimeoutExpired:
                process.terminate()  # it sends the safe frame and ends
                with suppress(subprocess.TimeoutExpired):
                    process.wait(_LEAVES_WITHIN_S)

    def _say(self, note: Note) -> None:
        if self._pipe is None:
            raise PortLostError("the guardian of the port has died")
        try:
            self._pipe.sendall(note.to_bytes())
        except OSError:
            self._bury()
        if self._lost:
            raise PortLostError(self._lost)

    def _listen(self, until_s: float) -> None:
        """What the guardian has said by then has been heard, the first of it at once."""
        if self._pipe is None:
            raise PortLostError("the guardian of the port has died")
        ready, _, _ = select.select([self._pipe], [], [], max(0.0, until_s - self.now()))
        if not ready:
            return
        try:
            data = self._pipe.recv(_MOST_BYTES)
        except OSError:
            data = b""
        if not data:
            self._bury()
        for note in self._reader.feed(data):
            self._hear(note)
        if self._lost and not self._data:
            raise PortLostError(self._lost)

    def _bury(self) -> None:
        self._dismiss()
        raise PortLostError("the guardian of the port has died")

    def _hear(self, note: Note) -> None:
        if note.kind == Kind.DATA:
            self._data.append(note.body)
        elif note.kind == Kind.OPENED:
            self._opened, self._lost = True, ""
        elif note.kind == Kind.REFUSED:
            self._refused = note.body.decode()
        elif note.kind == Kind.LOST:
            self._opened, self._lost = False, note.body.decode()
        elif note.kind == Kind.OVERRULED:
            self._overruled = True
