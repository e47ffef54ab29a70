"""A simulated robot in its surroundings, advanced by whole cycles of the bus.

One board reports per cycle, in turn, as on the real link (thesis section 4-2). The simulator's
backend and the emulated bay both use it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from pirate_sm.core.events import (
    BuiltInFault,
    FaultReport,
    FrameBlock,
    InSpace,
    SensorFrame,
    Truth,
    Whereabouts,
)
from pirate_sm.core.geometry import GRAVITY_M_S2, Bend, drawn_walls
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.simulation.acting_defect import Incident
from pirate_sm.simulation.defects import AtWork, named, put_to_work
from pirate_sm.simulation.electronics import (
    ROLL,
    BoardChannels,
    Electronics,
    SlotRoute,
    routes_of,
    sensors_of,
)
from pirate_sm.simulation.physics import ChainBody, MakePhysics, QuantityLayout, chain_of
from pirate_sm.simulation.standing import Standing
from pirate_sm.simulation.start_pose import standing_again
from pirate_sm.simulation.surroundings import (
    NO_JITTER,
    Jitter,
    Obstacles,
    PipeChanges,
    surroundings_of,
)


@dataclass(frozen=True, kw_only=True)
class FullTruth(Truth):
    """The true state: positions for views, and quantities that only a simulation knows.

    Attributes:
        arcs_m: Position of each wheel along the pipe.
        bends_rad: Angle at each wheel between its two links.
        torques_nm: Torque in the bend joint at each wheel; 0 without a joint.
        gone: Whether the robot has left the pipe for good.
    """

    arcs_m: tuple[float, ...]
    bends_rad: tuple[float, ...]
    torques_nm: tuple[float, ...]
    gone: bool


_TOUCHING_N = 0.05
# Cycles between two checks whether the robot has left the pipe, and how far it is gone then.
_GONE_EVERY = 16
_GONE_M = 0.4
# Nearer to the pipe than this no wheel has left it, whatever the rounding.
_NEAR_M = -1e-9


class CycleReading(NamedTuple):
    """The channels that one cycle reads.

    Attributes:
        board: The board.
        first: First row of the channel table; ``last`` is the row after the last.
    """

    board: BoardChannels
    first: int
    last: int

    @property
    def channel(self) -> int:
        """Number of the first channel within its board."""
        return self.first - self.board.first


class Leeway(NamedTuple):
    """Where a robot may be while its surroundings do nothing to it.

    Attributes:
        out_of_plane_rad: How far a part may be turned out of the plane of the bends.
        touching: Whether it is in a round pipe, where it may be anywhere as long as a wheel touches
            a wall. In bars it may be in these limits.
        before_m: How far back the foremost wheel may be along the pipe.
        behind_m: How far ahead the rearmost wheel may be.
    """

    out_of_plane_rad: float
    touching: bool
    before_m: float
    behind_m: float


class SimulatedRobot:
    """A simulated robot in a pipe.

    Args:
        profile: The robot's profile.
        pipe: The pipe.
        physics: Makes the physics that moves the robot.
        seed: Seed of all random numbers; equal seeds give equal runs.
        start_values: Setpoints of the configuration at the start, one per slot, for a start with
            clamped parts; None for a straight robot.
        jitter: How far start, friction and diameter may differ from the files.
        defects: Which of the profile's defects to switch on, as text with their numbers.
        more_defects: Further defects.
        put_back: How the robot stands, instead of where its pipe says; None: there.

    Attributes:
        electronics: Its boards.
        physics: What moves it.
        gone: Whether it has left the pipe for good.
        left_pipe: The fault of a robot that has left its pipe; None of one in it.
        cycles: How many cycles have passed.
        arcs: Positions of the wheels along the pipe, m; a view of the array of the physics.
        time_s: The time by which the surroundings change.

    Raises:
        UsageError: The robot does not fit into the pipe, the pipe intersects itself, or the
            profile has no such defect.
    """

    def __init__(
        self,
        profile: Profile,
        pipe: Pipe,
        physics: MakePhysics,
        *,
        seed: int,
        start_values: Sequence[float] | None = None,
        jitter: Jitter = NO_JITTER,
        defects: Sequence[str] = (),
        more_defects: Sequence[AtWork] = (),
        put_back: Standing | None = None,
    ) -> None:
        chain = chain_of(profile)
        routes, sensors = routes_of(profile, chain), sensors_of(profile, chain)
        if put_back is not None:
            start_values = put_back.values
        self._start_duties = _joint_duties(chain, routes, start_values)
        self._roll_target_rad = 0.0
        rng = np.random.default_rng(seed)
        duties = self._start_duties
        around = surroundings_of(profile, chain, pipe, duties=duties, jitter=jitter, rng=rng)
        if put_back is not None:
            target = next(
                (v for r, v in zip(routes, put_back.values, strict=True) if r.motor == ROLL), 0.0
            )
            around = replace(around, pose=standing_again(chain, profile, put_back, target))
            self._roll_target_rad = target
        self._route, self._chain = around.route, chain
        self._flat = around.route.section == "bars"
        self._axes = 2 if self._flat else 3
        self._cycle_s = profile.link.cycle
        self.physics = physics(chain, around.route, around.friction, around.pose, self._cycle_s)
        self._layout = QuantityLayout(chain.nodes)
        self.arcs = self.physics.quantities[self._layout.block("arc")]
        noise_seed = int(rng.integers(2**63))
        self.electronics = Electronics(chain, routes, sensors, self.physics, noise_seed)
        at_work = [*named(defects, profile, seed), *more_defects]
        self._effects = put_to_work(at_work, self.electronics)
        self._obstacles = Obstacles(self.physics, chain, around.route, around.obstacles)
        self._changes = PipeChanges(
            *(self.physics, chain.nodes, pipe, around.route),
            *(around.friction, around.friction_scale),
        )
        self.time_s = put_back.at_s if put_back is not None else 0.0
        self.cycles, self.gone = 0, False
        self.left_pipe: FaultReport | None = None
        self._start_m = sum(self.arcs_m) / chain.nodes

    def hold(self) -> None:
        """Drive the joints with the duties of the start pose, the roll joint to its target."""
        self.physics.turn_roll_to(self._roll_target_rad)
        for motor, duty in self._start_duties.items():
            self.physics.duties[motor] = duty

    def turns(self, one_value: bool) -> tuple[CycleReading, ...]:
        """Return the turns of the cycles: a board each, or one value each."""
        boards = self.electronics.boards
        if not one_value:
            return tuple(CycleReading(each, each.first, each.last) for each in boards)
        return tuple(
            CycleReading(each, row, row + 1)
            for each in boards
            for row in range(each.first, each.last)
        )

    def step(self, now_s: float, turn: CycleReading) -> Sequence[Incident]:
        """Simulate a cycle and read the turn's channels; return incidents on the boards."""
        self.cycles += 1
        self.time_s += self._cycle_s
        if not self.gone:
            self._changes.step(self.time_s)
            self.physics.advance()
        self.electronics.read(turn.first, turn.last)
        return self.strike(now_s) if self._effects else ()

    def strike(self, now_s: float) -> Sequence[Incident]:
        """Let the defects act on the robot; return the incidents."""
        return [found for each in self._effects if (found := each.step(now_s)) is not None]

    @property
    def moved_until_s(self) -> float:
        """Until when it has moved: the end of the last cycle."""
        return self.cycles * self._cycle_s

    @property
    def due_s(self) -> float:
        """When the next defect strikes; infinite if none will."""
        return min((effect.due_s for effect in self._effects), default=math.inf)

    def meet_obstacles(self) -> FaultReport | None:
        """Apply the obstacles after a cycle; return the fault of one, or of an end of the pipe."""
        fault = self._obstacles.step(self.time_s, self._cycle_s)
        if self.cycles % _GONE_EVERY == 0 and not self.gone:
            self._look_whether_gone()
            if self.left_pipe is None and self._is_outside(0.0):
                message = "every wheel is beyond a pipe's end"
                self.left_pipe = BuiltInFault.ROBOT_LEFT_PIPE.report(message)
                return self.left_pipe
        return fault

    def glides_until_s(self, now_s: float) -> float:
        """Return until when only the physics and the sensors act; before ``now_s`` if others do."""
        if self.gone:
            return -math.inf
        # The surroundings have a clock of their own, which goes on while the controller restarts.
        around_s = min(self._changes.due_s(self.time_s), self._obstacles.due_s) - self.time_s
        around_s += now_s - self._cycle_s
        until_s = min([around_s, *(each.glides_until_s(now_s) for each in self._effects)])
        # Each defect acts on what the one before it shows; here all act on what is measured.
        return until_s if len(self._effects) < 2 or not self.forced(now_s) else -math.inf

    def forced(self, now_s: float) -> dict[int, float]:
        """Return the counts that defects show instead of those measured, by row."""
        return {row: shown for each in self._effects for row, shown in each.forced(now_s).items()}

    def glided(
        self, cycles: int, time_s: float, frames: FrameBlock, last: SensorFrame | None
    ) -> None:
        """Note that cycles have passed in which only the physics and the sensors have acted.

        Args:
            cycles: How many cycles have passed.
            time_s: The time by which the surroundings change.
            frames: The frames in that time.
            last: One more frame after them, if any.
        """
        self.passed(cycles, time_s)
        for effect in self._effects:
            for _, frame in frames.frames():
                effect.took(frame.board, list(frame.values))
            if last is not None:
                effect.took(last.board, list(last.values))

    def passed(self, cycles: int, time_s: float) -> None:
        """Note that cycles have passed in which nothing has been reported; see :meth:`glided`."""
        self.cycles += cycles
        self.time_s = time_s

    def read(self, now_s: float, turn: CycleReading) -> list[float] | None:
        """Return the counts of the turn's channels; None if a defect loses them."""
        first = turn.board.first
        counts = self.frame(now_s, turn.board)
        return counts[turn.first - first : turn.last - first] if counts is not None else None

    def frame(self, now_s: float, board: BoardChannels) -> list[float] | None:
        """Return the counts of a board's channels; None if a defect loses them."""
        counts: list[float] | None = self.electronics.counts[board.first : board.last].tolist()
        for effect in self._effects:
            if counts is None:
                return None
            counts = effect.frame(now_s, board.board, board.first, counts)
        return counts

    def delivery(self, now_s: float) -> tuple[bool, bool]:
        """Return whether defects let an array arrive, and its echo."""
        arrives = echoes = True
        for effect in self._effects:
            delivered, answered = effect.delivery(now_s)
            arrives, echoes = arrives and delivered, echoes and answered
        return arrives, echoes

    def set_values(self, values: Sequence[float]) -> None:
        """Put the setpoints in force, clipped to the limits of their slots."""
        self.electronics.set_values(self.electronics.cut(values))

    @property
    def leeway(self) -> Leeway:
        """Where the robot may be, from now on, while its surroundings do nothing to it."""
        turned_rad, behind_m = self._obstacles.out_of_plane_rad, self._route.length_m + _NEAR_M
        if any(abs(roll) >= turned_rad for roll in self.physics.rolls()[1:]):
            clear_m = self._obstacles.clear_m()
            if clear_m is not None:  # it may turn as it likes until it comes nearer to a bend
                ends = max(clear_m[0], -_NEAR_M), min(clear_m[1], behind_m)
                return Leeway(math.inf, not self._flat, *ends)
        return Leeway(turned_rad, not self._flat, -_NEAR_M, behind_m)

    @property
    def truth(self) -> FullTruth:
        """The robot's true position and state."""
        arcs_m, in_space = self.arcs_m, self.in_space
        return FullTruth(
            wheels=self.wheels,
            wheel_radius_m=self._chain.wheel_radius_m,
            walls=drawn_walls(self._route),
            distance_m=sum(arcs_m) / len(arcs_m) - self._start_m,
            touching=tuple(press > _TOUCHING_N for press in self.values("press")),
            rolls_rad=in_space.rolls_rad,
            z_m=in_space.z_m,
            run=self._route.piece_at(arcs_m[0]).run,
            arc_m=arcs_m[0],
            arcs_m=tuple(arcs_m),
            bends_rad=tuple(self.values("bend")),
            torques_nm=tuple(self.values("bend_torque")),
            gone=self.gone,
        )

    @property
    def wheels(self) -> tuple[tuple[float, float], ...]:
        """Position of each wheel in the drawing of the pipe, m; cheaper than ``truth``."""
        return tuple((x, y) for x, y, _ in self.physics.places())

    @property
    def in_space(self) -> InSpace:
        """What ``wheels`` leaves out; no third coordinates where the robot moves in a plane."""
        z_m = () if self._flat else tuple(z for _, _, z in self.physics.places())
        return InSpace(z_m, tuple(self.physics.rolls()))

    @property
    def trail_columns(self) -> int:
        """How many numbers say where it is: coordinates of each wheel, then three rolls."""
        return self._axes * self._chain.nodes + 3

    @property
    def whereabouts(self) -> Callable[[Sequence[bytes]], Whereabouts]:
        """Return a function that says where it was from rows of such numbers, without the robot."""
        return partial(_whereabouts, self._axes, self._chain.nodes)

    @property
    def arcs_m(self) -> list[float]:
        """Position of each wheel along the pipe, m; cheaper than ``truth``, for detectors."""
        found: list[float] = self.arcs.tolist()
        return found

    @property
    def bends(self) -> tuple[Bend, ...]:
        """Where the pipe turns."""
        return self._route.bends

    @property
    def duties(self) -> tuple[float, ...]:
        """Duties in force: of the joints at each wheel, then of the wheels."""
        return tuple(self.physics.duties.tolist())

    def values(self, quantity: str) -> list[float]:
        """Return a quantity of every wheel after the last cycle; see `physics.QuantityLayout`."""
        found: list[float] = self.physics.quantities[self._layout.block(quantity)].tolist()
        return found

    def _is_outside(self, bars_m: float = _GONE_M) -> bool:
        """Return whether every wheel is far from the pipe; from one between bars by this much."""
        if self._flat:
            arcs = self.arcs_m
            return max(-max(arcs), min(arcs) - self._route.length_m) >= bars_m
        if any(self.values("press")):
            return False
        # It may fall past an open end, or be in a pipe that is not on its route.
        pieces = [piece for run in self._route.placement.runs.values() for piece in run]
        return all(
            piece.nearest(place, 0.0, piece.length_m)[0] >= _GONE_M
            for place in self.physics.places()
            for piece in pieces
        )

    def _look_whether_gone(self) -> None:
        """Bring a robot that is far outside the pipe to rest, with zero torques and speeds."""
        if self._is_outside():
            self.gone = True
            # It lies on the floor: the accelerometer measures its weight, in any pose.
            for axis, value in (("acc_x", 0.0), ("acc_y", 0.0), ("acc_z", GRAVITY_M_S2)):
                self.physics.quantities[self._layout.at(axis)] = value


def _whereabouts(axes: int, nodes: int, noted: Sequence[bytes]) -> Whereabouts:
    count = axes * nodes
    rows = np.frombuffer(b"".join(noted)).reshape(-1, count + 3)
    wheels, rolls_rad = rows[:, :count], rows[:, count:].tolist()
    if axes == 2:  # a plane
        return Whereabouts(wheels.tolist(), [()] * len(rows), rolls_rad)
    by_wheel = wheels.reshape(len(rows), -1, 3)
    places_m = by_wheel[:, :, :2].reshape(len(rows), -1)
    return Whereabouts(places_m.tolist(), by_wheel[:, :, 2].tolist(), rolls_rad)


def _joint_duties(
    chain: ChainBody, routes: Sequence[SlotRoute], values: Sequence[float] | None
) -> dict[int, float]:
    """Return the duties of bend joints among these setpoints, by the wheel of the joint."""
    if values is None:
        return {}
    return {
        route.motor: value
        for route, value in zip(routes, values, strict=True)
        if 0 <= route.motor < chain.nodes and value != 0.0
    }
