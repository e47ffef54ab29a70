"""Reasons from outside to end a run before its mission does, and the signals that bring them."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from math import inf
from types import FrameType
from typing import NamedTuple, Self

OUTPUT_LOST = 141
"""Exit code when nobody reads any more: 128 + SIGPIPE, as a shell shows it."""


class Stop(NamedTuple):
    """Why a run must end, and the exit code that says so."""

    reason: str
    exit_code: int


BY_SIGNAL = {
    signal.SIGINT: Stop("interrupted by Ctrl-C", 130),
    signal.SIGTERM: Stop("told to terminate (SIGTERM)", 143),
    signal.SIGHUP: Stop("the terminal has gone (SIGHUP)", 129),
    signal.SIGQUIT: Stop("told to quit (SIGQUIT)", 131),
    signal.SIGUSR1: Stop("told to end (SIGUSR1)", 138),
    signal.SIGUSR2: Stop("told to end (SIGUSR2)", 140),
    signal.SIGALRM: Stop("told to end (SIGALRM)", 142),
}
"""Every signal that would else end this process with the robot still moving."""


class StopRequests:
    """What has asked the run to stop so far; handlers write it, the loop reads it.

    Attributes:
        stop: The first request.
        urgent: Whether a person has insisted: there is no time for the engine's own safe stop.
    """

    def __init__(self) -> None:
        self.stop: Stop | None = None
        self.urgent = False

    def ask(self, stop: Stop) -> None:
        """Ask for an end through the engine's safe stop; the first reason counts."""
        if self.stop is None:
            self.stop = stop

    def insist(self) -> None:
        """Ask for an end at once, with the safe array sent past the engine."""
        self.urgent = True


PATIENCE_S = 3.0
"""Once a person has insisted, the safe array has this long to go out before a signal may break
into it: several times what a backend needs to close."""

UNFINISHED = "interrupted before the safe stop was finished: look at the robot"


class CaughtSignals:
    """Turns signals into requests while it is entered.

    The first one asks, a second one other than SIGHUP insists. Later ones change nothing until
    ``PATIENCE_S`` have passed: they must not break into the safe stop. Then, in case a backend
    hangs, one raises KeyboardInterrupt. A signal that this process was started to ignore
    (``nohup``, a job in the background) stays ignored.

    Args:
        requests: Where the requests go.
        ends_process: Whether the process ends after this. Once a stop has been asked for, later
            signals are then ignored instead of being handled as before.
        now: Reads a monotonic clock, s.
    """

    def __init__(
        self,
        requests: StopRequests,
        *,
        ends_process: bool = False,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._requests = requests
        self._ends_process = ends_process
        self._now = now
        self._insisted_s = inf
        self._over = False
        self._before: dict[signal.Signals, object] = {}

    def __enter__(self) -> Self:
        """Catch the signals."""
        for number in BY_SIGNAL:
            if signal.getsignal(number) != signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._catch)
        return self

    def __exit__(self, *_: object) -> None:
        """Handle the signals as before, or ignore them where the process ends after a stop."""
        self._over = True
        if self._ends_process and self._requests.stop is not None:
            return
        for number, before in self._before.items():
            signal.signal(number, before)  # type: ignore[arg-type]

    def _catch(self, number: int, _frame: FrameType | None) -> None:
        if self._over:
            return
        caught = signal.Signals(number)
        if self._requests.stop is None:
            self._requests.ask(BY_SIGNAL[caught])
        elif caught == signal.SIGHUP:
            return
        elif not self._requests.urgent:
            self._insisted_s = self._now()
            self._requests.insist()
        elif self._now() >= self._insisted_s + PATIENCE_S:
            raise KeyboardInterrupt(UNFINISHED)
