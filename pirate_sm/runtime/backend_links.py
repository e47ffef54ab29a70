"""Companions between a backend and a run: pass on the safe array and the backend's remarks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import inf

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import Event


class Holder:
    """Passes the safe array to the backend at every turn, to be sent should this process die.

    Args:
        hold: Receives the present safe array and the slots that position loops drive.
    """

    due_s = inf
    listening = False

    def __init__(self, hold: Callable[[tuple[float, ...], Collection[int]], None]) -> None:
        self._hold = hold
        self._engine: Engine | None = None
        self._state: Callable[[], EngineState | None] = lambda: None

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Follow this run from now on."""
        self._engine, self._state = engine, state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Pass on the present safe array, and the slots that position loops drive."""
        state = self._state()
        if self._engine is not None and state is not None:
            self._hold(self._engine.safe_values(state), self._engine.seeking(state))

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return nothing."""
        return ()


class Messenger:
    """Passes the backend's remarks on to people while the mission itself stands still.

    Args:
        remark: Returns each remark of the backend once; empty if there is none.
    """

    listening = False

    def __init__(self, remark: Callable[[], str]) -> None:
        self._remark = remark
        self._text = ""

    @property
    def due_s(self) -> float:
        """Now, if there is a remark; else infinite."""
        self._text = self._text or self._remark()
        return -inf if self._text else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return the backend's remark."""
        text, self._text = self._text, ""
        return (Log("warning", text),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return nothing, because remarks do not concern the engine."""
        return ()
