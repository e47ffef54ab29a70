"""Protocols of objects that follow a run: observers, watchers, taps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from pirate_sm.core.effects import Effect
from pirate_sm.core.events import Event
from pirate_sm.core.resuming import AS_DECLARED, Beginning

if TYPE_CHECKING:
    from pirate_sm.core.sensing import Glide

PULSE_S = 0.05


class Observer(Protocol):
    """Receives every effect; raises ``OSError`` when its output cannot be written any more."""

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Receive the latest effects."""


@runtime_checkable
class Watcher(Protocol):
    """Is called every ``PULSE_S`` of the wall clock."""

    def pulse(self, now_s: float) -> None:
        """Look at the run."""


class Tap(Protocol):
    """Receives every input and output of the engine, in order; never raises.

    Attributes:
        stepwise: Whether it looks at the run after each step, so that it cannot use blocks.
    """

    stepwise: bool

    @property
    def due_s(self) -> float:
        """Return when it looks at the engine next: at the first step that reaches this time."""

    def start(
        self,
        seen: Sequence[Event],
        now_s: float,
        effects: Sequence[Effect],
        begins: Beginning = AS_DECLARED,
    ) -> None:
        """Receive the start of the engine, with the events known then."""

    def take(self, event: Event, now_s: float, effects: Sequence[Effect]) -> None:
        """Receive a step; a step in which the engine raised has no effects."""

    def secure(self) -> None:
        """Return when all that was received is on the disk, or soon if that takes too long."""

    def take_glide(self, glide: Glide) -> None:
        """Receive the steps that were taken at once, and where the robot was at each."""

    def abandon(self, now_s: float, effects: Sequence[Effect]) -> None:
        """Receive the effects of actions past the engine."""
