"""A simulated ruler: it measures from outside how fast the robot moves along the pipe."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from random import Random

from pirate_sm.core.effects import Effect
from pirate_sm.core.events import Event, OutsideNumber
from pirate_sm.core.simulation import RulerSettings


class Ruler:
    """A companion that knows the true places and reports the noisy speed of their mean.

    Args:
        settings: Which signal it measures, how often, and how well.
        places: Returns a time in s, and where each wheel was along the pipe then, m, front to rear.
        seed: Of its errors.
    """

    listening = False

    def __init__(
        self,
        settings: RulerSettings,
        places: Callable[[], tuple[float, Sequence[float]]],
        seed: int,
    ) -> None:
        self.due_s = 0.0
        self._settings = settings
        self._places = places
        self._chance = Random(f"ruler {seed}")
        self._last: tuple[float, float] | None = None

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Do nothing: what counts is where the robot is."""

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the mean speed since the last look, m/s, positive ahead."""
        self.due_s = now_s + self._settings.every
        seen_s, places_m = self._places()
        place_m = sum(places_m) / len(places_m)
        if places_m[0] < places_m[-1]:
            place_m = -place_m  # it heads against the pipe
        before, self._last = self._last, (seen_s, place_m)
        if before is None or seen_s <= before[0]:
            return ()
        speed_m_s = (place_m - before[1]) / (seen_s - before[0])
        error_m_s = self._chance.gauss(0.0, self._settings.noise)
        return (OutsideNumber(self._settings.signal, speed_m_s + error_m_s),)
