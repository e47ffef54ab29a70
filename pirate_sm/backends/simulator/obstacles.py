"""What stands in a robot's way besides the walls: obstacles, and bends that it cannot take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pirate_sm.backends.simulator.world import World
from pirate_sm.model.events import FaultReport
from pirate_sm.model.fault_codes import BuiltInFault

_PUSHED_WITHIN_M = 0.0005
# A wheel is this wide; a part turned farther out of a bend's plane catches on the mitre.
_OUT_OF_PLANE_RAD = math.radians(10.0)


@dataclass(frozen=True)
class Obstacle:
    """Something in the pipe.

    Attributes:
        arc_m: Where it stands.
        from_s: When it is put there; only while no part of the robot is in that place.
        lasting_s: How long it withstands a push; infinite for a wall.
    """

    arc_m: float
    from_s: float = 0.0
    lasting_s: float = math.inf


class Obstacles:
    """Puts obstacles in the robot's way, one at a time, and takes them away again."""

    def __init__(self, obstacles: Sequence[Obstacle]) -> None:
        self._waiting = sorted(obstacles, key=lambda obstacle: obstacle.from_s)
        self._standing: Obstacle | None = None
        self._pushed_s = 0.0
        self._reported: set[float] = set()

    def step(self, world: World, cycle_s: float) -> FaultReport | None:
        """Move obstacles to where they should be now; return the fault of an impassable bend."""
        rolls: list[float] = world.state.roll.tolist()
        in_plane = max(map(abs, rolls[1:])) < _OUT_OF_PLANE_RAD
        if in_plane and not self._waiting and self._standing is None:
            return None
        arcs = world.arcs()
        fault = self._out_of_plane(world, rolls, arcs)
        if self._standing is None and self._waiting:
            self._put(world, arcs)
        if self._standing is not None:
            self._hold(world, self._standing, arcs, cycle_s)
        return fault

    def _put(self, world: World, arcs: Sequence[float]) -> None:
        radius = world.machine.chain.wheel_radius_m
        for obstacle in self._waiting:
            clear = min(arcs) - radius > obstacle.arc_m or max(arcs) + radius < obstacle.arc_m
            if world.time_s >= obstacle.from_s and clear:
                self._standing = obstacle
                self._waiting.remove(obstacle)
                self._pushed_s = 0.0
                return

    def _hold(
        self, world: World, obstacle: Obstacle, arcs: Sequence[float], cycle_s: float
    ) -> None:
        ahead = max(arcs) < obstacle.arc_m
        wheel = arcs.index(max(arcs) if ahead else min(arcs))
        world.block(wheel, obstacle.arc_m, ahead)
        gap = abs(obstacle.arc_m - arcs[wheel]) - world.machine.chain.wheel_radius_m
        if gap < _PUSHED_WITHIN_M:
            self._pushed_s += cycle_s
        if self._pushed_s >= obstacle.lasting_s:
            self._standing = None
            world.unblock()

    def _out_of_plane(
        self, world: World, rolls: Sequence[float], arcs: Sequence[float]
    ) -> FaultReport | None:
        """A part that is not in the plane of the bend it comes to is stopped there."""
        split = world.machine.chain.roll_link
        for part in (1, 2):
            off = math.remainder(rolls[part], 2.0 * math.pi)
            if abs(off) < _OUT_OF_PLANE_RAD:
                continue
            wheels = [i for i in range(world.nodes) if (i <= split) == (part == 1)]
            for number, crossing in enumerate(world.pipe.crossings_m, start=1):
                bend = world.pipe.legs[number - 1].bend
                assert bend is not None  # a crossing is where a leg with a bend ends
                reach = 0.5 * world.pipe.shape.diameter_m * math.tan(abs(bend.angle_rad) / 2.0)
                reach += world.machine.chain.wheel_radius_m
                near = [i for i in wheels if abs(arcs[i] - crossing) < reach + 0.005]
                if near and (crossing not in self._reported):
                    self._reported.add(crossing)
                    before = arcs[near[0]] < crossing
                    stop = crossing - reach if before else crossing + reach
                    self._standing = Obstacle(stop)
                    return BuiltInFault.PIPE_IMPASSABLE.report(
                        f"bend {number} lies {math.degrees(abs(off)):.0f} deg out of the plane of"
                        f" wheel {near[0] + 1}; align the part with the bend first",
                    )
        return None
