"""A serial port that a guardian owns, as the runner sees it, and the guardian's process."""

from __future__ import annotations

import os
import select
import socket
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from math import inf

from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.serial.guardian.guard import (
    BEATS,
    Instructions,
    Note,
    NoteKind,
    NoteReader,
)
from pirate_sm.robot.backends.serial.guardian.takeover import LeftBehind, take_over
from pirate_sm.robot.backends.serial.link.conversation import SilenceTimer
from pirate_sm.robot.backends.serial.port import PortLostError

# --- the guardian's process -----------------------------------------------------------------------


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


# --- the port -------------------------------------------------------------------------------------


_STARTS_WITHIN_S = 15.0
_STOPS_WITHIN_S = 6.0
"""Longer than a boot loader runs, and long enough even if every second frame is lost."""

_HUNG_AFTER_S = 1.0
"""A guardian that has not acknowledged a beat for this long hangs. It may block for half a second
while the port takes nothing."""

_NICE = -10
"""Ahead of usual programs (0), after those that keep the system alive (-20) [decided]."""

_DIED = "the guardian of the port has died"
_HUNG = "the guardian of the port did not answer and was replaced"


class GuardedPort:
    """Starts a guardian for a port and uses the port through it.

    Args:
        url: A device such as ``/dev/ttyACM0``, or any URL of pyserial.
        baud: Baud rate of the line.
        instructions: The guardian's instructions.
    """

    def __init__(self, url: str, baud: int, instructions: Instructions) -> None:
        self.name = url
        self.epoch_s = time.time() - time.monotonic()
        self._baud = baud
        self._instructions = instructions
        self._silence_s = instructions.silence_s
        self._guardian: GuardianProcess | None = None
        self._data: deque[bytes] = deque()
        self._acknowledged = SilenceTimer(_HUNG_AFTER_S / BEATS)
        self._heard_s = -inf
        self._safe_frame = b""
        self._lost = ""
        self._opened = False
        self._refused = ""
        self._overruled = False
        self._stopped = False
        self._remark = ""
        self._nice: int | None = None
        self._thread = 0

    now = staticmethod(time.monotonic)

    @property
    def guardian_pid(self) -> int | None:
        """Process id of the guardian; None when there is none."""
        return self._guardian.pid if self._guardian is not None else None

    # --- opening and closing ----------------------------------------------------------------

    def open(self) -> None:
        """Start a guardian and wait until it has the port.

        If an earlier run has left the robot without a confirmed stop, the robot is stopped first.

        Raises:
            BackendError: The port cannot be opened, or the robot does not confirm its stop.
        """
        # Another thread may close it, and a priority is that of a thread on Linux.
        self._thread = threading.get_native_id() if sys.platform == "linux" else 0
        self._nice = _hurry(_NICE, self._thread)
        left = self._start()
        if not self._await(lambda: self._opened or bool(self._refused), _STARTS_WITHIN_S):
            self._refused = "the guardian of the serial port does not answer"
        refused = self._refused
        if not refused and left is not None:
            refused = self._await_stop()
        if refused:
            going_on = self._leave(dismissed=left is None)
            _hurry(self._nice, self._thread)
            raise BackendError("; ".join(filter(None, (refused, going_on))))

    def _start(self) -> LeftBehind | None:
        """Start a guardian; return an earlier one whose stop is not confirmed yet, if any."""
        self._forget()
        left = take_over(self.name, self._instructions.array_md5)
        self._guardian = GuardianProcess(self._silence_s)
        if self._safe_frame:
            self._guardian.send(Note(NoteKind.BEAT, self._safe_frame))  # should we die at once
        elif left is not None:
            self._guardian.send(Note(NoteKind.STOP, left.payload))
        self._guardian.start(self.name, str(self._baud), self._instructions.to_json())
        self._acknowledged.hear(self.now())
        return left

    def _forget(self) -> None:
        self._data.clear()
        self._opened, self._refused, self._lost = False, "", ""
        self._overruled = self._stopped = False
        self._beat_s = -inf

    def _await(self, true: Callable[[], bool], within_s: float) -> bool:
        """Wait until the condition is true; return whether it became true.

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
        """Wait until the robot has confirmed its stop; return the problem if it does not."""
        within_s = self._instructions.boot_s + _STOPS_WITHIN_S
        what = f"an earlier run has left the robot on {self.name} without a confirmed stop"
        if not self._await(lambda: self._stopped, within_s):
            return f"{what}, and it confirms none now"
        self._notify(Note(NoteKind.HEED))
        self._remark = f"{what}: it is stopped now, as it has confirmed"
        return ""

    def reopen(self) -> bool:
        """Return whether the guardian has the port again; start another guardian if needed."""
        if self._guardian is None:
            self._start()
        with suppress(PortLostError):
            self._listen(self.now())
        if not self._opened:
            return False
        self._lost = ""
        self._data.clear()
        return True

    def close(self, stopped: bool = False) -> None:
        """End the guardian, unless the robot has not confirmed its stop; closed twice as once."""
        _hurry(self._nice, self._thread)
        self._remark = self._leave(dismissed=stopped or not self._safe_frame) or self._remark
        self._safe_frame = b""  # a guardian stays with the robot, or none is needed

    def remark(self) -> str:
        """Return, once, what a person must know about other guardians of the port."""
        remark, self._remark = self._remark, ""
        return remark

    def _leave(self, dismissed: bool = False) -> str:
        """Disconnect from the guardian; return what a person must know if it stays.

        Args:
            dismissed: Whether the robot needs no guardian any more.
        """
        if dismissed:
            self._send(Note(NoteKind.LEAVE))
        elif self._safe_frame and not self._answers():
            self._kill()
            self._start()
        guardian, self._guardian = self._guardian, None
        if guardian is None or guardian.hang_up():
            return ""
        if dismissed:
            guardian.kill()
            return ""
        guardian.leave()
        stay_s = self._instructions.stay_s
        return (
            f"cut the robot's power: it has not confirmed that it stopped. A guardian of the port "
            f"(process {guardian.pid}) keeps trying for {stay_s / 60:g} min, and gives the port "
            f"to a new run; `kill {guardian.pid}` ends it"
        )

    def _answers(self) -> bool:
        """Return whether the guardian acknowledges a beat."""
        with suppress(PortLostError):
            self._listen(self.now())  # older answers say nothing
            asked_s = self._heard_s = self.now()
            if self._send(Note(NoteKind.BEAT, self._safe_frame)):
                while self._heard_s == asked_s and self.now() < asked_s + _HUNG_AFTER_S:
                    self._listen(asked_s + _HUNG_AFTER_S)
                return self._heard_s != asked_s
        return False

    def _kill(self) -> None:
        """Kill the guardian, so that another can open the port."""
        guardian, self._guardian = self._guardian, None
        if guardian is not None:
            guardian.kill()

    # --- what a port does -------------------------------------------------------------------

    def write(self, data: bytes) -> None:
        """Send the bytes to the guardian in one piece."""
        self._notify(Note(NoteKind.WRITE, data))

    def read(self, until_s: float) -> bytes:
        """Return received bytes as soon as there are any; empty if none came by ``until_s``."""
        if not self._data:
            self._listen(until_s)
        if self._lost and not self._data:
            raise PortLostError(self._lost)
        return self._data.popleft() if self._data else b""

    def wait(self, until_s: float) -> None:
        """Sleep until that time."""
        time.sleep(max(0.0, until_s - self.now()))

    def beat(self, safe_frame: bytes) -> None:
        """Send the guardian a sign of life and the frame to send if these signs stop.

        A guardian that hangs is killed; :meth:`reopen` starts another.
        """
        now = self.now()
        if safe_frame == self._safe_frame and now - self._beat_s < self._silence_s / BEATS:
            return
        self._beat_s, self._safe_frame = now, safe_frame
        if self._guardian is None:
            return
        self._notify(Note(NoteKind.BEAT, safe_frame))
        # A guardian needs longer to open a port on a network.
        limit_s = _HUNG_AFTER_S if self._opened else _STARTS_WITHIN_S
        if self._acknowledged.look(now) >= limit_s:
            self._kill()
            raise PortLostError(_HUNG)

    def overruled(self) -> bool:
        """Return whether the guardian has acted since the last call; if so, let it relay again."""
        overruled, self._overruled = self._overruled, False
        if overruled:
            self._notify(Note(NoteKind.HEED))
            self._beat_s = -inf
        return overruled

    # --- the pipe ---------------------------------------------------------------------------

    def _notify(self, note: Note) -> None:
        if self._guardian is None:
            raise PortLostError(_DIED)
        try:
            self._guardian.send(note)
        except TimeoutError:  # otherwise it would use the port when it wakes
            self._kill()
            raise PortLostError(_HUNG) from None
        except OSError:
            self._abandon()
        if self._lost:
            raise PortLostError(self._lost)

    def _send(self, note: Note) -> bool:
        try:
            if self._guardian is not None:
                self._guardian.send(note)
        except OSError:
            return False
        return self._guardian is not None

    def _listen(self, until_s: float) -> None:
        """Take in notes of the guardian until ``until_s``; return after the first."""
        if self._guardian is None:
            raise PortLostError(_DIED)
        notes = self._guardian.receive(until_s - self.now())
        if notes is None:
            self._abandon()
            return
        for note in notes:
            self._hear(note)

    def _abandon(self) -> None:
        """Give up a guardian that has closed the pipe; it may go on until the robot has stopped."""
        guardian, self._guardian = self._guardian, None
        if guardian is not None and not guardian.hang_up():
            guardian.leave()
        raise PortLostError(_DIED)

    def _hear(self, note: Note) -> None:
        match note.kind:
            case NoteKind.DATA:
                self._data.append(note.body)
            case NoteKind.OPENED:
                self._opened = True
            case NoteKind.REFUSED:
                self._refused = note.body.decode()
            case NoteKind.LOST:
                self._opened, self._lost = False, note.body.decode()
            case NoteKind.OVERRULED:
                self._overruled = True
            case NoteKind.STOPPED:
                self._stopped = True
            case NoteKind.HEARD:
                self._heard_s = self.now()
                self._acknowledged.hear(self._heard_s)
            case NoteKind.WRITE | NoteKind.BEAT | NoteKind.HEED | NoteKind.LEAVE | NoteKind.STOP:
                pass  # kinds that only the runner sends


def _hurry(nice: int | None, thread: int) -> int | None:
    """Give a thread, and those that it starts, a priority where that is allowed; 0 is this one.

    Returns:
        The priority before; None where there is none.
    """
    if nice is None or not hasattr(os, "setpriority"):
        return None
    before = None
    with suppress(OSError):  # it is not allowed, or the thread has ended
        before = os.getpriority(os.PRIO_PROCESS, thread)
        os.setpriority(os.PRIO_PROCESS, thread, nice)
    return before
