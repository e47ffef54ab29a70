"""A backend in which nothing moves: it accepts every array at once and time can jump.

The engine counts commands as done after their nominal duration. So a mission can be followed from
start to end without a robot, a pipe or a simulator.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import inf

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import Event, SubmitResult, SubmitStatus
from pirate_sm.robot.backends.protocol import Completion

IDEAL = (
    "trace: nothing moves, no sensor speaks; every command succeeds after its nominal duration "
    "and every wait is passed by its first trigger or by the script"
)
"""The note printed before a trace, so that nobody takes it for a prediction."""

SCRIPTED = (
    "trace: nothing moves, no sensor speaks; what happens is laid down in the script, and then "
    "all goes well; its time limit counts from then on"
)
"""The note when the events of a script are played."""


class Verdicts:
    """Results of arrays as a script decides; without a script, or after it, all are accepted.

    Args:
        scripted: Whether arrays wait for a decision.
    """

    def __init__(self, *, scripted: bool = False) -> None:
        self._scripted = scripted
        self._decided: deque[tuple[SubmitStatus, str]] = deque()

    def decide(self, status: SubmitStatus, reason: str = "") -> None:
        """Set the result of the oldest array that waits."""
        self._decided.append((status, reason))

    def release(self) -> None:
        """Accept every undecided array from now on."""
        self._scripted = False

    def next(self) -> tuple[SubmitStatus, str] | None:
        """Return the result of the next array; None while it has to wait."""
        if self._decided:
            return self._decided.popleft()
        return None if self._scripted else ("accepted", "")


class TraceBackend:
    """The ideal world, except for what a script decides.

    Args:
        verdicts: Decides the results of arrays; without it all are accepted.
        known: Events known at the start.
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
        """Return the events known at the start."""
        return self._known

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Accept the array at once, or let it wait for the script.

        Raises:
            BackendError: The backend has been closed.
        """
        if self._closed:
            raise BackendError("the trace is closed")
        if setpoint_id not in self._waiting:
            self._waiting.append(setpoint_id)

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Return results without letting time pass; without any, jump to ``until_s``.

        Raises:
            BackendError: Nothing can ever happen any more.
        """
        results = self._decided()
        if results:
            return self._now_s, results
        if until_s == inf:
            raise BackendError("the mission waits forever: no further event can happen")
        self._now_s = max(self._now_s, until_s)
        return self._now_s, ()

    def _decided(self) -> tuple[Event, ...]:
        found = []
        while self._waiting and (verdict := self._verdicts.next()) is not None:
            found.append(SubmitResult(self._waiting.popleft(), *verdict))
        return tuple(found)

    def close(self) -> None:
        """Accept no more arrays."""
        self._closed = True
