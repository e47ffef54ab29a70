"""Companions that keep a backend and a run in touch: what to hold, and what people must know."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from math import inf

from pirate_sm.engine.engine import Engine
from pirate_sm.engine.state import EngineState
from pirate_sm.model.effects import Effect, Log
from pirate_sm.model.events import Event


class Holder:
    """Tells a backend at every turn what is to be held and what stopped, should this process die.

    Args:
        hold: Receives the safe array of this moment and the slots that position loops drive.
    """

    due_s = inf
    listening = False

    def __init__(self, hold: Callable[[tuple[float, ...], Collection[int]], None]) -> None:
        self._hold = hold
        self._engine: Engine | None = None
        self._state: Callable[[], EngineState | None] = lambda: None

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        """Pass on what this run holds from now on."""
        self._engine, self._state = engine, state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Pass on the safe array of this moment, and the slots that position loops drive."""
        state = self._state()
        if self._engine is not None and state is not None:
            self._hold(self._engine.safe_values(state), self._engine.seeking(state))

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return nothing."""
        return ()


class Messenger:
    """Passes on what a backend wants people to know while the mission itself stands still.

    Args:
        remark: What there is to be said now, once; empty: nothing.
    """

    listening = False

    def __init__(self, remark: Callable[[], str]) -> None:
        self._remark = remark
        self._text = ""

    @property
    def due_s(self) -> float:
        """Now where there is something to say."""
        self._text = self._text or self._remark()
        return -inf if self._text else inf

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing: what happens does not matter to it."""

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Return what the backend has to say."""
        text, self._text = self._text, ""
        return (Log("warning", text),)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return nothing: the engine is not concerned."""
        return ()
