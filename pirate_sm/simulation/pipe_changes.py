"""What changes around a robot while it moves: friction from place to place, gravity in time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from pirate_sm.core.geometry import Route, Vector, tilted_up
from pirate_sm.core.pipe import Pipe, Turns
from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.physics import Physics, QuantityLayout


def gravity_of(pipe: Pipe) -> Callable[[float], Vector] | None:
    """Return how the direction against gravity depends on time; None where it never turns."""
    turns = pipe.turns
    if turns is None:
        return None

    def up(now_s: float, turns: Turns = turns) -> Vector:
        share = min(max((now_s - turns.from_s) / (turns.to - turns.from_s), 0.0), 1.0)
        return tilted_up(pipe.tilt + share * (turns.tilt - pipe.tilt), pipe.uphill)

    return up


_NOT_YET: Vector = (0.0, 0.0, 0.0)


class PipeChanges:
    """Gives a physics the friction where its wheels are, and the gravity of the time.

    Both change once per cycle, where they change at all.

    Args:
        physics: Moves the robot.
        wheels: How many it has.
        pipe: Where it is.
        route: Its way through the pipe.
        friction: Of the wall outside its patches.
        scale: What the coefficients of the patches are multiplied by.
    """

    def __init__(
        self,
        physics: Physics,
        wheels: int,
        pipe: Pipe,
        route: Route,
        friction: Friction,
        scale: float,
    ) -> None:
        self._physics = physics
        self._arcs = physics.quantities[QuantityLayout(wheels).block("arc")]
        self._stretches = [
            (each.from_m, each.to_m, (each.friction.static * scale, each.friction.kinetic * scale))
            for each in pipe.stretches(route)
        ]
        self._usual = (friction.static, friction.kinetic)
        self._given = [self._usual] * wheels
        self._turns = pipe.turns
        self._gravity, self._up = gravity_of(pipe), _NOT_YET
        self._idle = self._gravity is None and not self._stretches

    def due_s(self, now_s: float) -> float:
        """Return when something may change next; before ``now_s`` if it may at any moment."""
        if self._stretches or (self._turns is not None and self._up == _NOT_YET):
            return -math.inf
        if self._turns is None or now_s > self._turns.to:
            return math.inf
        return self._turns.from_s

    def step(self, now_s: float) -> None:
        """Give the physics what is true of a cycle that begins now."""
        if self._idle:
            return
        if self._gravity is not None:
            up = self._gravity(now_s)
            if up != self._up:
                self._up = up
                self._physics.turn_gravity(up)
        if self._stretches:
            self._give(self._arcs.tolist())

    def _give(self, arcs_m: Sequence[float]) -> None:
        for wheel, arc_m in enumerate(arcs_m):
            inside = (own for begin, end, own in self._stretches if begin <= arc_m < end)
            own = next(inside, self._usual)
            if own != self._given[wheel]:
                self._given[wheel] = own
                self._physics.let_grip(wheel, *own)
