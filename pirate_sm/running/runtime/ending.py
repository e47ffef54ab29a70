"""How a run ends: requests to end it before its mission does, its outcome, and its exit code."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from math import inf
from types import FrameType
from typing import NamedTuple, Self

from pirate_sm.core.effects import Ended
from pirate_sm.core.errors import ExitCode

# --- requests -------------------------------------------------------------------------------------


class Stop(NamedTuple):
    """The reason to end a run, and the exit code for it."""

    reason: str
    exit_code: int


BY_SIGNAL = {
    signal.SIGINT: Stop("interrupted by Ctrl-C", 130),
    signal.SIGTERM: Stop("asked to terminate (SIGTERM)", 143),
    signal.SIGHUP: Stop("the terminal has gone (SIGHUP)", 129),
    signal.SIGQUIT: Stop("asked to quit (SIGQUIT)", 131),
    signal.SIGUSR1: Stop("asked to end (SIGUSR1)", 138),
    signal.SIGUSR2: Stop("asked to end (SIGUSR2)", 140),
    signal.SIGALRM: Stop("asked to end (SIGALRM)", 142),
}
"""Every signal that would otherwise end this process with the robot still moving."""


class StopRequests:
    """The requests to stop so far; signal handlers write it, the loop reads it.

    Attributes:
        stop: The first request.
        urgent: Whether an operator has asked again, so that the engine's safe stop takes too long.
    """

    def __init__(self) -> None:
        self.stop: Stop | None = None
        self.urgent = False

    def ask(self, stop: Stop) -> None:
        """Ask for an end through the engine's safe stop; the first reason counts."""
        if self.stop is None:
            self.stop = stop

    def insist(self) -> None:
        """Ask for an immediate end, with the safe array sent past the engine."""
        self.urgent = True


PATIENCE_S = 3.0
"""After a second request the safe array has this long to go out before a signal may interrupt it:
several times the time a backend needs to close."""

UNFINISHED = "interrupted before the safe stop was finished: look at the robot"


class CaughtSignals:
    """Turns signals into requests while it is entered.

    The first signal asks for a stop, a second one other than SIGHUP for an immediate one. Later
    ones do nothing until ``PATIENCE_S`` have passed, because they must not interrupt the safe
    stop. After that a signal raises KeyboardInterrupt, in case a backend hangs. A signal that this
    process ignored at its start (``nohup``, a job in the background) stays ignored.

    Args:
        requests: Receives the requests.
        ends_process: Whether the process ends after this. If so, later signals are ignored after
            a request to stop; without one, they are handled as before, but Ctrl-C as usual.
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
        """Restore the handlers; if the process ends after a stop, ignore the signals instead."""
        self._over = True
        if self._ends_process and self._requests.stop is not None:
            return
        if self._ends_process and signal.SIGINT in self._before:
            self._before[signal.SIGINT] = signal.default_int_handler
        for number, before in self._before.items():
            signal.signal(number, before)  # type: ignore[arg-type]

    def _catch(self, number: int, _frame: FrameType | None) -> None:
        caught, first = signal.Signals(number), self._requests.stop is None
        self._requests.ask(BY_SIGNAL[caught])
        if self._over or first or caught == signal.SIGHUP:
            return
        if not self._requests.urgent:
            self._insisted_s = self._now()
            self._requests.insist()
        elif self._now() >= self._insisted_s + PATIENCE_S:
            raise KeyboardInterrupt(UNFINISHED)


# --- the outcome ----------------------------------------------------------------------------------


LINK_FAMILIES = ("backend", "link", "runner")
"""Families of fault codes about the link to the robot, not the robot itself."""


class Result(NamedTuple):
    """The end of a run.

    Attributes:
        ended: The effect that ended the run.
        exit_code: 0 succeeded, 1 mission failed (also by a fault of the robot), 3 backend or link
            fault, 4 an internal error, 129, 130, 141 and 143 stopped from outside.
        now_s: Mission time, s.
        error: The exception that ended the run, if any.
    """

    ended: Ended
    exit_code: int
    now_s: float
    error: BaseException | None = None


def exit_code(ended: Ended, fault: str, stop: Stop | None, output_lost: bool) -> int:
    """Return the exit code of a run that the engine has ended.

    Args:
        ended: How it ended.
        fault: Code of the last fault without a handler; empty if none.
        stop: The request to stop, if any.
        output_lost: Whether its output could not be written.
    """
    if ended.outcome == "interrupted":
        return stop.exit_code if stop else ExitCode.FAILED  # a trace that would never end
    if ended.outcome == "fault":
        return ExitCode.BACKEND if fault.partition(".")[0] in LINK_FAMILIES else ExitCode.FAILED
    if ended.outcome == "failed":
        return ExitCode.FAILED
    return ExitCode.OUTPUT_LOST if output_lost else ExitCode.SUCCEEDED
