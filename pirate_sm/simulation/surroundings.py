"""The surroundings of a run: a pipe, its friction and gravity, obstacles, and the start pose."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import BuiltInFault, FaultReport
from pirate_sm.core.geometry import Piece, Route, Vector, tilted_up
from pirate_sm.core.models import Friction, Pipe, Profile, Turns
from pirate_sm.simulation.physics import ChainBody, Physics, QuantityLayout, StartPose
from pirate_sm.simulation.start_pose import stand

# --- obstacles -----------------------------------------------------------------------------------


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


# --- surroundings --------------------------------------------------------------------------------


@dataclass(frozen=True)
class Jitter:
    """How far a run may differ from its files; each value is drawn uniformly within plus and minus.

    Attributes:
        start_m: Position of the robot along the pipe.
        friction: Both friction coefficients, as a share.
        diameter_m: Inner diameter.
        friction_scale: What the friction coefficients of every run are multiplied by; not drawn.
        wider_m: How much wider the pipe of every run is; not drawn.
        forward_m: How much farther along the pipe every run begins; not drawn.
    """

    start_m: float = 0.0
    friction: float = 0.0
    diameter_m: float = 0.0
    friction_scale: float = 1.0
    wider_m: float = 0.0
    forward_m: float = 0.0


NO_JITTER = Jitter()


def drawn_jitter(jitter: Jitter, rng: np.random.Generator) -> Jitter:
    """Return by how much one run differs from its files; a run's first random numbers draw it."""
    start, friction, diameter = rng.uniform(-1.0, 1.0, 3).tolist()
    return Jitter(start * jitter.start_m, friction * jitter.friction, diameter * jitter.diameter_m)


@dataclass(frozen=True)
class Surroundings:
    """The surroundings and the pose at the start of a run.

    Attributes:
        route: The way through the pipe.
        friction: Friction of the wall.
        friction_scale: What every coefficient in the files is multiplied by.
        pose: How the robot stands.
        obstacles: Obstacles in the pipe.
    """

    route: Route
    friction: Friction
    friction_scale: float
    pose: StartPose
    obstacles: tuple[Obstacle, ...]


def surroundings_of(
    profile: Profile,
    chain: ChainBody,
    pipe: Pipe,
    *,
    duties: Mapping[int, float],
    jitter: Jitter,
    rng: np.random.Generator,
) -> Surroundings:
    """Draw a run's random deviations and return its surroundings.

    Args:
        profile: The robot's profile.
        chain: The robot's moving parts.
        pipe: The pipe.
        duties: Duty of each bend joint that is wound up, by its wheel; empty for a straight,
            unclamped robot.
        jitter: How far the numbers may differ from the files.
        rng: Random numbers.

    Raises:
        UsageError: The robot does not fit into the pipe, or the pipe intersects itself.
    """
    differs = drawn_jitter(jitter, rng)
    route = Route(pipe.network(jitter.wider_m + differs.diameter_m))
    _check(route.pieces)
    coefficients = pipe.friction if pipe.friction is not None else profile.simulation.friction
    scale = jitter.friction_scale * (1.0 + differs.friction)
    scaled = {"static": coefficients.static * scale, "kinetic": coefficients.kinetic * scale}
    arc_m = pipe.start_of(chain.length_m) + jitter.forward_m + differs.start_m
    roll = (pipe.start.roll if pipe.start else 0.0) - pipe.roll
    return Surroundings(
        route,
        coefficients.model_copy(update=scaled),
        scale,
        stand(chain, route, arc_m, duties, roll),
        tuple(Obstacle(each.at, each.from_s, each.lasting) for each in pipe.blockages),
    )


def _check(pieces: Sequence[Piece]) -> None:
    for number, piece in enumerate(pieces, start=1):
        least_m = sum(piece.taken_m)
        if 0.0 < least_m >= piece.length_m:
            raise UsageError(
                f"straight {number} is {piece.length_m * 1000:.0f} mm long; the walls of its mitres"
                f" meet unless it is longer than {least_m * 1000:.0f} mm"
            )


# --- changes on the way --------------------------------------------------------------------------


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
