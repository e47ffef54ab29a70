"""Ends a trace that has come back to an earlier situation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf

from pirate_sm.core.effects import Ask, Effect, Log, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Abort, Event


class LoopWatch:
    """Ends a trace that comes back to an earlier situation.

    Only a script decides what happens in a trace. If a situation recurs and the script has no new
    entry for it, the mission would repeat itself without end.

    Args:
        pending: Returns how many entries of the script are unused.
    """

    listening = False

    def __init__(self, pending: Callable[[], int]) -> None:
        self.due_s = inf
        self._pending = pending
        self._seen: set[object] = set()
        self._repeated = ""

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask to look when the mission begins a wait or asks a question."""
        if any(isinstance(each, WaitArmed) or _asks(each) for each in effects):
            self.due_s = now_s

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Compare the situation, without its times, with all earlier ones."""
        mission = state.mission._replace(
            armed_s=0.0, since=(), offset_s=0.0, second_s=0.0, entered=0
        )
        body = state.robot._replace(next_id=0)
        situation = (mission, body, state.words, state.rules, self._pending())
        self._repeated = LOOP if situation in self._seen else ""
        self._seen.add(situation)
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the end of the run if the situation has recurred."""
        self.due_s = inf
        return (Abort(self._repeated),) if self._repeated else ()


LOOP = (
    "the trace has come back to a situation in which it has been before: from here the mission "
    "would repeat itself without end (other triggers must be fired)"
)


def _asks(effect: Effect) -> bool:
    return isinstance(effect, Ask) and bool(effect.question)
