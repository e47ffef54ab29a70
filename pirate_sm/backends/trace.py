"""A backend in which nothing moves: it takes every array at once and lets time jump.

With it the engine takes commands as done after their nominal duration, so a mission can be read
through from its start to an end without a robot, a pipe or a simulator.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from pirate_sm.backends.protocol import Completion
from pirate_sm.errors import BackendError
from pirate_sm.model.events import Event, SubmitResult

IDEAL = (
    "trace: nothing moves, no sensor speaks; every command succeeds after its nominal duration "
    "and every wait is passed by its first trigger or by the script"
)
"""What must be said before anybody takes a trace for a prediction."""


class TraceBackend:
    """The ideal world."""

    name = "trace"
    completion: Completion = "nominal"
    real_time = False

    def __init__(self) -> None:
        self._now_s = 0.0
        self._results: list[Event] = []
        self._closed = False

    def open(self) -> Sequence[Event]:
        """It is ready; there is nothing to know."""
        return ()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """The array counts as accepted at this very moment.

        Raises:
            BackendError: It has been closed.
        """
        if self._closed:
            raise BackendError("the trace is closed")
        self._results.append(SubmitResult(setpoint_id, "accepted"))

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Results are handed out without time passing; without any, it is ``until_s``.

        Raises:
            BackendError: Nothing is left that could ever happen.
        """
        if self._results:
            results, self._results = tuple(self._results), []
            return self._now_s, results
        if until_s == inf:
            raise BackendError("the mission waits for ever: nothing is left that could happen")
        self._now_s = max(self._now_s, until_s)
        return self._now_s, ()

    def close(self) -> None:
        """It takes nothing more."""
        self._closed = True
