"""Who is told what happens: lines, a live view, later a recorder."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from pirate_sm.model.effects import Effect

PULSE_S = 0.05


class Observer(Protocol):
    """Is told every effect; an ``OSError`` from it means that nobody reads it any more."""

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """It has taken note of what has just happened."""
        ...


@runtime_checkable
class Watcher(Protocol):
    """Looks at the run in between, every ``PULSE_S`` of the wall's time."""

    def pulse(self, now_s: float) -> None:
        """It has looked."""
        ...
