"""A backend in which nothing moves and every array is answered a quarter of a second later."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

from pirate_sm import BackendError, LoadedMission, UsageError
from pirate_sm.plugins import (
    Completion,
    Equipment,
    Event,
    MakeBackend,
    Order,
    Plugin,
    Say,
    SubmitResult,
    TriggerScript,
)

ANSWER_S = 0.25


class SlowLine:
    """See the module."""

    name = "slow_line"
    completion: Completion = "nominal"
    real_time = False

    def __init__(self) -> None:
        self._now_s = 0.0
        self._answers: list[tuple[float, SubmitResult]] = []
        self._closed = False

    def open(self) -> Sequence[Event]:
        """Return nothing: nothing is known before the first array."""
        return ()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Answer the array a quarter of a second later."""
        if self._closed:
            raise BackendError("the line is closed")
        self._answers.append((self._now_s + ANSWER_S, SubmitResult(setpoint_id, "accepted")))

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Go to the next answer, or to the time that was asked for."""
        now_s = min([until_s, *(at_s for at_s, _ in self._answers)])
        if now_s == inf:
            raise BackendError("nothing will ever happen")
        self._now_s = max(self._now_s, now_s)
        answers = [answer for at_s, answer in self._answers if at_s <= self._now_s]
        self._answers = [each for each in self._answers if each[0] > self._now_s]
        return self._now_s, answers

    def close(self) -> None:
        """Take nothing more."""
        self._closed = True


def make(order: Order, loaded: LoadedMission, say: Say) -> Equipment:
    """Return the backend, with a script that takes the first trigger of each wait."""
    if order.defects:
        raise UsageError("slow_line has no robot that could have a defect")
    return Equipment(backend=SlowLine(), companions=(TriggerScript(loaded.program),))


BACKEND: Plugin[MakeBackend] = Plugin("every array is answered late", make)
