"""Requests of the operator to stop or leave, for all runs of a session, and how long that takes."""

from __future__ import annotations

import os
import signal
import sys
import termios
from collections.abc import Callable
from contextlib import suppress
from threading import Thread
from typing import Any

from pirate_sm.running.runtime.ending import BY_SIGNAL, Stop, StopRequests
from pirate_sm.running.runtime.loop import Clock, WallClock

LEAVE_WITHIN_S = 1.7
"""How long leaving may take once the operator has gone and the robot is safe. With the time to
notice it, 2 s."""

SAFE_WITHIN_S = 5.0
"""The safe stop, which takes 0.1 s, may take so long on a busy machine."""

_LOOK_EVERY_S = 0.05

_GONE = frozenset(BY_SIGNAL.values()) - {BY_SIGNAL[signal.SIGINT]}
"""Requests after which nobody waits for the process to end by itself. Ctrl-C is a person's."""

_RESTORED = "\x1b[<u\x1b[?1000l\x1b[?1003l\x1b[?1006l\x1b[?2004l\x1b[?1004l\x1b[?1049l\x1b[?25h"
"""Ends what the console asks of a terminal: its keys, mouse, paste, focus and second screen."""


class LeaveRequests(StopRequests):
    """Requests to leave; signals make them too.

    Attributes:
        gone: The first request made without a person at the terminal; None without one.
    """

    def __init__(self) -> None:
        super().__init__()
        self.gone: Stop | None = None

    def ask(self, stop: Stop) -> None:
        """Ask to leave; the first reason counts."""
        super().ask(stop)
        if self.gone is None and stop in _GONE:
            self.gone = stop

    @property
    def safe(self) -> bool:
        """Whether no robot needs this process any more; here there is none."""
        return True


class Quitting(LeaveRequests):
    """Requests that end the session with its present run.

    Args:
        unreachable: Returns whether nothing comes from the robot.

    Attributes:
        stopped: Whether the robot has been brought to its safe state after a request.
    """

    def __init__(self, unreachable: Callable[[], bool] = lambda: False) -> None:
        super().__init__()
        self.run = StopRequests()
        self.stopped = False
        self._unreachable = unreachable

    @property
    def safe(self) -> bool:
        """Whether the robot stands, or only its guardian can still stop it."""
        return self.stopped or self._unreachable()

    def begin(self) -> StopRequests:
        """Return the requests of the next run, with a stop if the session was asked to stop."""
        self.run = StopRequests()
        if self.stop is not None:
            self.run.ask(self.stop)
        return self.run

    def ask(self, stop: Stop) -> None:
        """End the present run through the engine's safe stop; no run follows."""
        super().ask(stop)
        self.run.ask(stop)

    def insist(self) -> None:
        """End it at once, with the safe array sent past the engine."""
        super().insist()
        self.run.insist()


class Watchdog:
    """Ends this process where leaving takes too long after the operator has gone.

    The safe stop is the first thing that leaving does, and the limit counts from its end. Where it
    takes too long itself, the guardian, which owns the port, continues without this process.

    Args:
        requests: The requests to leave.
        end: Ends the process with an exit code; called in a thread of its own.
        clock: The wall clock.
    """

    def __init__(
        self, requests: LeaveRequests, end: Callable[[int], object], clock: Clock | None = None
    ) -> None:
        self._requests, self._end = requests, end
        self._clock = clock or WallClock()

    def start(self) -> None:
        """Watch until the process ends."""
        Thread(target=self.watch, name="watchdog", daemon=True).start()

    def watch(self) -> None:
        """Wait until the operator has gone; end the process if it is still there after that."""
        while (gone := self._requests.gone) is None:
            self._clock.sleep(_LOOK_EVERY_S)
        give_up_s = self._clock.now() + SAFE_WITHIN_S
        while not self._requests.safe and self._clock.now() < give_up_s:
            self._clock.sleep(_LOOK_EVERY_S)
        self._clock.sleep(LEAVE_WITHIN_S)
        self._end(gone.exit_code)


def ender() -> Callable[[int], None]:
    """Return what ends this process at once and leaves its terminal as it is now."""
    terminal = sys.stdin.fileno()
    before: list[Any] = termios.tcgetattr(terminal)
    words = f"{_RESTORED}the console has ended before everything was closed: look at the robot\n"

    def end(code: int) -> None:
        # A process in the background would be stopped here.
        signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTTOU])
        with suppress(OSError, termios.error):
            termios.tcsetattr(terminal, termios.TCSANOW, before)
            # The terminal may take nothing, whatever `select` says: nothing must wait for it.
            again = os.open(os.ctermid(), os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
            os.write(again, words.encode())
        os._exit(code)

    return end
