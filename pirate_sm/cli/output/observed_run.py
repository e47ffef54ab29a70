"""The present state of a run; every kind of output reads it here."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan
from typing import TYPE_CHECKING

from pirate_sm.core.effects import Effect, Ended, Setpoints
from pirate_sm.core.simulation import Truth
from pirate_sm.running.wiring import Prepared
from pirate_sm.views.showing.left_state import left_state

if TYPE_CHECKING:
    from pirate_sm.core.engine import EngineState
    from pirate_sm.running.runtime.loop import MissionRun


class ObservedRun:
    """The present state of a run; ``run`` is set once it exists."""

    def __init__(self, prepared: Prepared) -> None:
        self.prepared = prepared
        self.robot = prepared.loaded.robot
        self.run: MissionRun | None = None
        self._sent: tuple[float, ...] = ()
        self._driven_from_m: float | None = None
        self._ended: Ended | None = None

    @property
    def now_s(self) -> float:
        """Mission time, s."""
        return self.run.now_s if self.run else 0.0

    @property
    def state(self) -> EngineState | None:
        """The engine's state, None before it began."""
        return self.run.state if self.run else None

    def truth(self) -> Truth | None:
        """Return the robot's true position, if it is known."""
        return self.prepared.truth() if self.prepared.truth else None

    def note(self, effects: Sequence[Effect]) -> None:
        """Note what was sent last, and the end."""
        for effect in effects:
            if isinstance(effect, Setpoints):
                self._sent = effect.values
                if self._driven_from_m is None and self.robot.travel(effect.values):
                    truth = self.truth()
                    self._driven_from_m = truth.distance_m if truth else None
            elif isinstance(effect, Ended):
                self._ended = effect

    def left(self) -> str:
        """Return in what state a run that did not succeed left the robot; empty otherwise."""
        ended, state, link = self._ended, self.state, self.prepared.link
        if ended is None or ended.outcome == "succeeded" or state is None:
            return ""
        return left_state(self.prepared.engine, state, self._sent, link() if link else None)

    def odometry_m(self) -> float | None:
        """Return the distance that the wheels have rolled, m, if it is measured."""
        state = self.state
        if state is None or self.robot.odometry < 0 or self.prepared.engine.nominal:
            return None
        value = state.sensing.numbers[self.robot.odometry]
        return None if isnan(value) else value

    def bound_m(self) -> float | None:
        """Return how far the robot may be from that distance, m, if the mission reads it."""
        state = self.state
        if state is None or self.robot.bound < 0 or self.odometry_m() is None:
            return None
        value = state.sensing.numbers[self.robot.bound]
        return None if isnan(value) else value

    def distance_m(self) -> float | None:
        """Return how far the robot has truly moved since it first drove, m, if it is known.

        Odometry counts from there too. Before, clamping moves the middle of the wheels by some
        20 mm, because a robot that folds is shorter.
        """
        truth = self.truth()
        return truth.distance_m - (self._driven_from_m or 0.0) if truth else None
