"""Reasons from outside to end a run before its mission does, and the signals that bring them."""

from __future__ import annotations

import signal
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
        """The run will end through the engine's safe stop; the first reason counts."""
        if self.stop is None:
            self.stop = stop

    def insist(self) -> None:
        """The run will end at once, with the safe array sent by the loop itself."""
        self.urgent = True


class CaughtSignals:
    """Turns signals into requests while it is entered.

    The first one asks. A second one other than SIGHUP insists; what was there before handles a
    third, in case a backend hangs. A signal that this process was started to ignore (``nohup``, a
    job in the background) stays ignored.
    """

    def __init__(self, requests: StopRequests) -> None:
        self._requests = requests
        self._before: dict[signal.Signals, object] = {}

    def __enter__(self) -> Self:
        """The signals are caught."""
        for number in BY_SIGNAL:
            if signal.getsignal(number) != signal.SIG_IGN:
                self._before[number] = signal.signal(number, self._catch)
        return self

    def __exit__(self, *_: object) -> None:
        """The signals do what they did before."""
        for number in tuple(self._before):
            self._restore(number)

    def _catch(self, number: int, _frame: FrameType | None) -> None:
        caught = signal.Signals(number)
        if self._requests.stop is None:
            self._requests.ask(BY_SIGNAL[caught])
        elif caught != signal.SIGHUP:
            self._requests.insist()
            self._restore(caught)

    def _restore(self, number: signal.Signals) -> None:
        if number in self._before:
            signal.signal(number, self._before.pop(number))  # type: ignore[arg-type]
