"""An operator who resumes a mission whenever it has been paused for a while."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf

from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import Effect
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.events import Event, Resume


class Resumes(CompanionBase):
    """Resumes, and notes which setpoints were in force during the pause.

    Attributes:
        arrays: These setpoints, one array for each pause.
    """

    PAUSED_S = 0.5

    def __init__(self) -> None:
        self.due_s = inf
        self.arrays: list[tuple[float, ...]] = []
        self._run: Callable[[], EngineState | None] = lambda: None

    def follow(self, engine: Engine, state: Callable[[], EngineState | None]) -> None:
        self._run = state

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        state = self._run()
        if state is not None and not state.mission.paused:
            self.due_s = inf
        elif state is not None and self.due_s == inf:
            self.due_s = now_s + self.PAUSED_S

    def speak(self, now_s: float) -> Sequence[Event]:
        state = self._run()
        assert state is not None
        self.due_s = inf
        self.arrays.append(state.robot.values)
        return (Resume(),)
