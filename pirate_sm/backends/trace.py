"""A backend in which nothing moves: it takes every array at once and lets time jump.

With it the engine takes commands as done after their nominal duration, so a mission can be read
through from its start to an end without a robot, a pipe or a simulator.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import inf

from pirate_sm.backends.protocol import Completion
from pirate_sm.errors import BackendError
from pirate_sm.model.events import Event, SubmitResult, SubmitStatus

IDEAL = (
    "trace: nothing moves, no sensor speaks; every command succeeds after its nominal duration "
    "and every wait is passed by its first trigger or by the script"
)
"""What must be said before anybody takes a trace for a prediction."""

SCRIPTED = (
    "trace: nothing moves, no sensor speaks; what happens is laid down in the script, and then "
    "all goes well; its time limit counts from then on"
)
"""The same, where a course of events is played."""


class Verdicts:
    """Fates of arrays that a script decides; without a script, or after it, all are accepted.

    Args:
        scripted: Whether arrays wait for a decision.
    """

    def __init__(self, *, scripted: bool = False) -> None:
        self._scripted = scripted
        self._decided: deque[tuple[SubmitStatus, str]] = deque()

    def decide(self, status: SubmitStatus, reason: str = "") -> None:
        """Decide the fate of the oldest array that waits."""
        self._decided.append((status, reason))

    def release(self) -> None:
        """Accept from now on whatever is not decided."""
        self._scripted = False

    def next(self) -> tuple[SubmitStatus, str] | None:
        """Return the fate of the next array; None while it is to wait."""
        if self._decided:
            return self._decided.popleft()
        return None if self._scripted else ("accepted", "")


class TraceBackend:
    """The ideal world, unless a script says otherwise.

    Args:
        verdicts: Whether arrays are accepted; all are without it.
        known: What is known at the start.
    """

    name = "trace"
    completion: Completion = "nominal"
    real_time = False

    def __init__(self, verdicts: Verdicts | None = None, known: Sequence[Event] = ()) -> None:
        self._now_s = 0.0
        self._verdicts = verdicts or Verdicts()
        self._known = tuple(known)
        self._waiting: deque[int] = deque()
        self._closed = False

    def open(self) -> Sequence[Event]:
        """Return what is known at the start."""
        return self._known

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Accept the array at this very moment, or let it wait for the script.

        Raises:
            BackendError: It has been closed.
        """
        if self._closed:
            raise BackendError("the trace is closed")
        if setpoint_id not in self._waiting:
            self._waiting.append(setpoint_id)

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Return results without letting time pass; without any, go to ``until_s``.

        Raises:
            BackendError: Nothing is left that could ever happen.
        """
        results = self._decided()
        if results:
            return self._now_s, results
        if until_s == inf:
            raise BackendError("the mission waits for ever: nothing is left that could happen")
        self._now_s = max(self._now_s, until_s)
        return self._now_s, ()

    def _decided(self) -> tuple[Event, ...]:
        found = []
        while self._waiting and (verdict := self._verdicts.next()) is not None:
            found.append(SubmitResult(self._waiting.popleft(), *verdict))
        return tuple(found)

    def close(self) -> None:
        """Take nothing more."""
        self._closed = True
