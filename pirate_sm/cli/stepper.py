"""The keys of an operator at a terminal whose mission a breakpoint has paused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import TYPE_CHECKING

from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import Effect, Log
from pirate_sm.core.events import Event, Resume, Step

if TYPE_CHECKING:
    from pirate_sm.core.engine import EngineState
    from pirate_sm.robot.detectors.simple_detectors import Keys

_ON, _STEP = "r", "."

STEPPER_KEYS = _ON + _STEP
"""The keys that resume a paused mission, and let it execute one step, as in the console."""

_LOOK_EVERY_S = 0.05


class Stepper(CompanionBase):
    """A companion that lets an operator resume a mission that a breakpoint has paused.

    Args:
        keys: Source of the keys.
    """

    due_s = inf

    def __init__(self, keys: Keys) -> None:
        self._keys = keys
        self._state: Callable[[], EngineState | None] = lambda: None
        self._says: Event | None = None

    def follow(self, engine: object, state: Callable[[], EngineState | None]) -> None:
        """Follow this run from now on."""
        self._state = state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Wait for the operator while the mission is paused."""
        state = self._state()
        paused = state is not None and state.mission.paused and not state.mission.ending
        if paused != self.listening:
            self.listening, self._says = paused, None
            self.due_s = now_s if paused else inf
            self._asks = paused

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Read the keys; return a log line with their meaning as the pause begins."""
        self.due_s = now_s + _LOOK_EVERY_S
        pressed, asks, self._asks = self._keys.pressed().lower(), self._asks, False
        if asks:  # earlier keys were meant for something else
            return (Log("info", f"{_ON} resumes, {_STEP} takes one step, Ctrl-C stops safely"),)
        key = next((each for each in pressed if each in STEPPER_KEYS), "")
        self._says = (Resume() if key == _ON else Step()) if key else None
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the request found by ``look``."""
        says, self._says = self._says, None
        return () if says is None else (says,)
