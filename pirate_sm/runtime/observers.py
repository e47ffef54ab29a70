"""Protocols of those who follow a run: observers, watchers, recorders."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from pirate_sm.model.effects import Effect
from pirate_sm.model.events import Event

if TYPE_CHECKING:
    from pirate_sm.engine.robot.robot_state import RobotState

PULSE_S = 0.05


class Observer(Protocol):
    """Receives every effect; an ``OSError`` from it means that nobody reads it any more."""

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Take note of what has just happened."""
        ...


@runtime_checkable
class Watcher(Protocol):
    """Looks at the run in between, every ``PULSE_S`` of the wall's time."""

    def pulse(self, now_s: float) -> None:
        """Look at the run."""
        ...


class Tap(Protocol):
    """Receives everything that the engine is given and gives back, in order; never raises."""

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        *,
        body: RobotState | None = None,
        paused: bool = False,
    ) -> None:
        """Take note of how the engine started, and of what it was given for that."""
        ...

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Take note of a step; one that broke the engine has no effects."""
        ...

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Take note of what was done past the engine."""
        ...
