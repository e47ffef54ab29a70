"""A serial port in the hands of a guardian, as the runner sees it."""

from __future__ import annotations

import select
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from math import inf

from pirate_sm.backends.serial.guardian.guard import BEATS
from pirate_sm.backends.serial.guardian.notes import Instructions, Kind, Note, NoteReader
from pirate_sm.backends.serial.guardian.takeover import LeftBehind, take_over
from pirate_sm.backends.serial.link.silence_timer import SilenceTimer
from pirate_sm.backends.serial.ports.protocol import PortLostError
from pirate_sm.errors import BackendError

_STARTS_WITHIN_S = 15.0
_LEAVES_WITHIN_S = 2.0
_STOPS_WITHIN_S = 6.0
"""Beyond the boot loader's time; with every second frame lost that is enough."""

_HUNG_AFTER_S = 1.0
"""A guardian that has not acknowledged a beat for this long hangs. It may wait for half a second
while the port takes nothing."""

_MOST_BYTES = 65536
_MODULE = "pirate_sm.backends.serial.guardian.process"
_DIED = "the guardian of the port has died"
_HUNG = "the guardian of the port did not answer and was replaced"

_left: list[subprocess.Popen[bytes]] = []
"""Guardians that go on without us: Python complains about processes that nobody waits for."""


class GuardedPort:
    """Starts a guardian for a port and speaks through it.

    Args:
        url: A device such as ``/dev/ttyACM0``, or any URL of pyserial.
        baud: Of the line.
        instructions: What the guardian must know.
    """

    def __init__(self, url: str, baud: int, instructions: Instructions) -> None:
        self.name = url
        self.epoch_s = time.time() - time.monotonic()
        self._baud = baud
        self._instructions = instructions
        self._silence_s = instructions.silence_s
        self._pipe: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._acknowledged = SilenceTimer(_HUNG_AFTER_S / BEATS)
        self._heard_s = -inf
        self._safe_frame = b""
        self._remark = ""
        self._forget()

    now = staticmethod(time.monotonic)

    @property
    def guardian_pid(self) -> int | None:
        """Number of the guardian's process; None when there is none."""
        return self._process.pid if self._process is not None else None

    # --- opening and closing ----------------------------------------------------------------

    def open(self) -> None:
        """Start a guardian that has the port.

        What a guardian of an earlier run has not finished is finished first: the robot confirms
        the array that stops it.

        Raises:
            BackendError: The port cannot be had, or the robot does not confirm that it stops.
        """
        left = self._start()
        if not self._await(lambda: self._opened or bool(self._refused), _STARTS_WITHIN_S):
            self._refused = "the guardian of the serial port does not answer"
        refused = self._refused
        if not refused and left is not None:
            refused = self._await_stop()
        if refused:
            going_on = self._leave(dismissed=left is None)
            raise BackendError("; ".join(filter(None, (refused, going_on))))

    def _start(self) -> LeftBehind | None:
        """Start a guardian; return the one that had been left on the port, if it must go on."""
        self._forget()
        left = take_over(self.name, self._instructions.array_md5)
        ours, theirs = socket.socketpair()
        if self._safe_frame:
            ours.sendall(Note(Kind.BEAT, self._safe_frame).to_bytes())  # should we die at once
        elif left is not None:
            ours.sendall(Note(Kind.STOP, left.payload).to_bytes())
        with theirs:
            # In a session of its own, without any stream of ours: the terminal's Ctrl-C and
            # hang-up are not for it, and nobody who reads our output waits for it.
            self._process = subprocess.Popen(
                [
                    *(sys.executable, "-m", _MODULE, str(theirs.fileno())),
                    *(self.name, str(self._baud), self._instructions.to_json()),
                ],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        ours.settimeout(self._silence_s)
        self._pipe = ours
        self._acknowledged.hear(self.now())
        return left

    def _forget(self) -> None:
        self._reader = NoteReader()
        self._data: deque[bytes] = deque()
        self._opened, self._refused, self._lost = False, "", ""
        self._overruled = self._stopped = False
        self._beat_s = -inf

    def _await(self, true: Callable[[], bool], within_s: float) -> bool:
        """Return whether it became true.

        Raises:
            BackendError: The guardian has died.
        """
        give_up_s = self.now() + within_s
        while not true() and self.now() < give_up_s:
            try:
                self._listen(give_up_s)
            except PortLostError:
                raise BackendError("the guardian of the serial port could not be started") from None
        return true()

    def _await_stop(self) -> str:
        """Wait until the robot has confirmed its stop; return what is wrong if it does not."""
        within_s = self._instructions.boot_s + _STOPS_WITHIN_S
        what = f"an earlier run has left the robot on {self.name} without a confirmed stop"
        if not self._await(lambda: self._stopped, within_s):
            return f"{what}, and it confirms none now"
        self._say(Note(Kind.HEED))
        self._remark = f"{what}: it is stopped now, as it has confirmed"
        return ""

    def reopen(self) -> bool:
        """Return whether the guardian has the port again; without a guardian start another."""
        if self._pipe is None:
            self._start()
        with suppress(PortLostError):
            self._listen(self.now())
        if not self._opened:
            return False
        self._lost = ""
        self._data.clear()
        return True

    def close(self, stopped: bool = False) -> None:
        """End the guardian; it stays if the robot has not confirmed its stop."""
        self._remark = self._leave(dismissed=stopped or not self._safe_frame)

    def remark(self) -> str:
        """Return what a person must know about who has had or keeps the port, once."""
        remark, self._remark = self._remark, ""
        return remark

    def _leave(self, dismissed: bool) -> str:
        """End the connection to the guardian; return what a person must know if it stays.

        Args:
            dismissed: Whether there is nothing left to guard.
        """
        if dismissed:
            self._send(Note(Kind.LEAVE))
        elif self._safe_frame and not self._answers():
            self._kill()
            self._start()
        process = self._process
        if self._hang_up():
            return ""
        assert process is not None  # it has just not ended
        if dismissed:
            process.kill()
            process.wait()
            return ""
        _left.append(process)
        stay_s = self._instructions.stay_s
        return (
            f"cut the robot's power: it has not confirmed that it stopped. A guardian of the port "
            f"(process {process.pid}) goes on trying for {stay_s / 60:g} min, and gives the port "
            f"to a new run; `kill {process.pid}` ends it"
        )

    def _answers(self) -> bool:
        """Return whether the guardian acknowledges a beat."""
        with suppress(PortLostError):
            self._listen(self.now())  # older answers say nothing
            asked_s = self._heard_s = self.now()
            if self._send(Note(Kind.BEAT, self._safe_frame)):
                while self._heard_s == asked_s and self.now() < asked_s + _HUNG_AFTER_S:
                    self._listen(asked_s + _HUNG_AFTER_S)
                return self._heard_s != asked_s
        return False

    def _hang_up(self) -> bool:
        """Close the pipe; return whether the guardian has ended."""
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None
        process, self._process = self._process, None
        if process is not None:
            try:
                process.wait(_LEAVES_WITHIN_S)
            except subprocess.TimeoutExpired:
                return False
        return True

    def _kill(self) -> None:
        """Kill the guardian, so that the next one can open the port."""
        process = self._process
        if process is not None:
            process.kill()
        self._hang_up()

    # --- what a port does -------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Give the bytes to the guardian in one piece."""
        self._say(Note(Kind.WRITE, data))

    def read(self, until_s: float) -> bytes:
        """Return what has come, as soon as anything has; empty when nothing had by ``until_s``."""
        if not self._data:
            self._listen(until_s)
        if self._lost and not self._data:
            raise PortLostError(self._lost)
        return self._data.popleft() if self._data else b""

    def wait(self, until_s: float) -> None:
        """Sleep until that time."""
        time.sleep(max(0.0, until_s - self.now()))

    def beat(self, safe_frame: bytes) -> None:
        """Tell the guardian that this program lives, and which frame to send when it does not.

        A guardian that hangs is killed; :meth:`reopen` starts another.
        """
        now = self.now()
        if safe_frame == self._safe_frame and now - self._beat_s < self._silence_s / BEATS:
            return
        self._beat_s, self._safe_frame = now, safe_frame
        if self._pipe is None:
            return
        self._say(Note(Kind.BEAT, safe_frame))
        # To open a port on a network takes a guardian longer.
        limit_s = _HUNG_AFTER_S if self._opened else _STARTS_WITHIN_S
        if self._acknowledged.look(now) >= limit_s:
            self._kill()
            raise PortLostError(_HUNG)

    def overruled(self) -> bool:
        """Return whether the guardian has acted since the last call; then let it relay again."""
        overruled, self._overruled = self._overruled, False
        if overruled:
            self._say(Note(Kind.HEED))
            self._beat_s = -inf
        return overruled

    # --- the pipe ---------------------------------------------------------------------------

    def _say(self, note: Note) -> None:
        if self._pipe is None:
            raise PortLostError(_DIED)
        try:
            self._pipe.sendall(note.to_bytes())
        except TimeoutError:  # left alone it would have the port as soon as it wakes
            self._kill()
            raise PortLostError(_HUNG) from None
        except OSError:
            self._bury()
        if self._lost:
            raise PortLostError(self._lost)

    def _send(self, note: Note) -> bool:
        try:
            if self._pipe is not None:
                self._pipe.sendall(note.to_bytes())
        except OSError:
            return False
        return self._pipe is not None

    def _listen(self, until_s: float) -> None:
        """Take in what the guardian says by then; return as soon as it has said something."""
        if self._pipe is None:
            raise PortLostError(_DIED)
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

    def _bury(self) -> None:
        """Give up a guardian that has closed the pipe; it may go on until the robot has stopped."""
        process = self._process
        if not self._hang_up() and process is not None:
            _left.append(process)
        raise PortLostError(_DIED)

    def _hear(self, note: Note) -> None:
        match note.kind:
            case Kind.DATA:
                self._data.append(note.body)
            case Kind.OPENED:
                self._opened = True
            case Kind.REFUSED:
                self._refused = note.body.decode()
            case Kind.LOST:
                self._opened, self._lost = False, note.body.decode()
            case Kind.OVERRULED:
                self._overruled = True
            case Kind.STOPPED:
                self._stopped = True
            case Kind.HEARD:
                self._heard_s = self.now()
                self._acknowledged.hear(self._heard_s)
            case Kind.WRITE | Kind.BEAT | Kind.HEED | Kind.LEAVE | Kind.STOP:
                pass  # what is only sent to the guardian
            case Kind.WRITE | Kind.BEAT | Kind.HEED | Kind.LEAVE | Kind.STOP:
                pass  # what only the guardian is sent
