"""Obstacles in the pipe, and bends that the robot cannot take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pirate_sm.core.events import BuiltInFault, FaultReport
from pirate_sm.core.geometry import Route
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.physics import Physics, QuantityLayout

_PUSHED_WITHIN_M = 0.0005
# Width of a wheel; a part turned farther out of a bend's plane catches on the mitre.
_OUT_OF_PLANE_RAD = math.radians(10.0)
# How near before it a wheel meets what stops it.
_NEARING_M = 0.005
# More than the physics lets a chain become longer.
_STRETCHED_M = 0.005


@dataclass(frozen=True)
class Obstacle:
    """An obstacle in the pipe.

    Attributes:
        arc_m: Its position along the pipe.
        from_s: When it appears; later if a part of the robot is in its place.
        lasting_s: How long it withstands a push; infinite for a wall.
    """

    arc_m: float
    from_s: float = 0.0
    lasting_s: float = math.inf


class Obstacles:
    """Puts obstacles in the robot's way, one at a time, and removes them again.

    Args:
        physics: Moves the robot.
        chain: The moving parts.
        route: The pipe.
        obstacles: The obstacles.
    """

    def __init__(
        self, physics: Physics, chain: ChainBody, route: Route, obstacles: Sequence[Obstacle]
    ) -> None:
        self._physics, self._chain, self._route = physics, chain, route
        self._arcs = physics.quantities[QuantityLayout(chain.nodes).block("arc")]
        self._waiting = sorted(obstacles, key=lambda obstacle: obstacle.from_s)
        # In a round pipe the walls themselves stop a part that is out of the plane of a bend.
        self._in_bars = route.pieces[0].section == "bars"
        self._standing: Obstacle | None = None
        self._pushed_s = 0.0
        self._reported: set[float] = set()

    @property
    def idle(self) -> bool:
        """Whether no obstacle stands or waits, so that only a bend out of plane can be met."""
        return not self._waiting and self._standing is None

    @property
    def due_s(self) -> float:
        """When the next obstacle may appear; before any time if one stands."""
        if self._standing is not None:
            return -math.inf
        return min((each.from_s for each in self._waiting), default=math.inf)

    @property
    def out_of_plane_rad(self) -> float:
        """How far a part may be turned; infinite without bends, and where the walls stop it."""
        return _OUT_OF_PLANE_RAD if self._in_bars and self._route.crossings_m else math.inf

    def clear_m(self) -> tuple[float, float] | None:
        """Return between which places a robot out of plane meets no bend; None if it may now.

        As long as the foremost wheel is ahead of the first place and the rearmost wheel behind the
        second, no wheel comes near a bend: all of them are in one leg, and their places differ by
        no more than the length of the chain.
        """
        first, last = float(self._arcs.min()), float(self._arcs.max())
        length_m = self._chain.length_m + _STRETCHED_M
        ahead_m, behind_m = -math.inf, math.inf
        for number, crossing in enumerate(self._route.crossings_m, start=1):
            near_m = self._reach_m(number) + _NEARING_M
            if last < crossing - near_m:
                behind_m = min(behind_m, crossing - near_m - length_m)
            elif first > crossing + near_m:
                ahead_m = max(ahead_m, crossing + near_m + length_m)
            else:
                return None
        return (ahead_m, behind_m) if last > ahead_m and first < behind_m else None

    def step(self, now_s: float, cycle_s: float) -> FaultReport | None:
        """Update the obstacles; return the fault of a bend between bars that is impassable."""
        rolls = self._physics.rolls() if self._in_bars else ()
        in_plane = all(abs(roll) < _OUT_OF_PLANE_RAD for roll in rolls[1:])
        if in_plane and self.idle:
            return None
        arcs: list[float] = self._arcs.tolist()
        fault = None if in_plane else self._out_of_plane(rolls, arcs)
        if self._standing is None and self._waiting:
            self._put(now_s, arcs)
        if self._standing is not None:
            self._hold(self._standing, arcs, cycle_s)
        return fault

    def _put(self, now_s: float, arcs: Sequence[float]) -> None:
        radius = self._chain.wheel_radius_m
        for obstacle in self._waiting:
            clear = min(arcs) - radius > obstacle.arc_m or max(arcs) + radius < obstacle.arc_m
            if now_s >= obstacle.from_s and clear:
                self._standing = obstacle
                self._waiting.remove(obstacle)
                self._pushed_s = 0.0
                return

    def _hold(self, obstacle: Obstacle, arcs: Sequence[float], cycle_s: float) -> None:
        ahead = max(arcs) < obstacle.arc_m
        wheel = arcs.index(max(arcs) if ahead else min(arcs))
        self._physics.block(wheel, obstacle.arc_m, ahead)
        gap = abs(obstacle.arc_m - arcs[wheel]) - self._chain.wheel_radius_m
        if gap < _PUSHED_WITHIN_M:
            self._pushed_s += cycle_s
        if self._pushed_s >= obstacle.lasting_s:
            self._standing = None
            self._physics.unblock()

    def _out_of_plane(self, rolls: Sequence[float], arcs: Sequence[float]) -> FaultReport | None:
        """Stop a part that is out of the plane of the bend ahead of it; return the fault."""
        split = self._chain.roll_link
        for part in (1, 2):
            off = math.remainder(rolls[part], 2.0 * math.pi)
            if abs(off) < _OUT_OF_PLANE_RAD:
                continue
            wheels = [i for i in range(self._chain.nodes) if (i <= split) == (part == 1)]
            for number, crossing in enumerate(self._route.crossings_m, start=1):
                reach = self._reach_m(number)
                near = [i for i in wheels if abs(arcs[i] - crossing) < reach + _NEARING_M]
                if near and (crossing not in self._reported):
                    self._reported.add(crossing)
                    before = arcs[near[0]] < crossing
                    stop = crossing - reach if before else crossing + reach
                    self._standing = Obstacle(stop)
                    return BuiltInFault.PIPE_IMPASSABLE.report(
                        f"bend {number} lies {math.degrees(abs(off)):.0f} deg out of the plane of"
                        f" wheel {near[0] + 1}; align the part with the bend first"
                    )
        return None

    def _reach_m(self, bend: int) -> float:
        """Return how near to the crossing of a bend, counted from 1, a wheel can come."""
        piece = self._route.pieces[bend - 1]
        assert piece.bend is not None  # a crossing is the end of a piece with a bend
        return piece.bend.taken_m(piece.diameter_m) + self._chain.wheel_radius_m
