"""A simulated robot in its surroundings, moved by whole cycles of the bus.

One board reports per cycle, in turn, as on the real link (thesis section 4-2). The simulator's
backend and the emulated bay both stand on it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pirate_sm.geometry import plane
from pirate_sm.geometry.space import GRAVITY_M_S2
from pirate_sm.model.events import FaultReport
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile
from pirate_sm.simulation.acting_defect import Incident
from pirate_sm.simulation.actuators import SlotRoute, routes_of
from pirate_sm.simulation.defects import AtWork, named, put_to_work
from pirate_sm.simulation.electronics import Electronics
from pirate_sm.simulation.full_truth import FullTruth
from pirate_sm.simulation.mechanics import ChainBody, chain_of
from pirate_sm.simulation.obstacles import Obstacles
from pirate_sm.simulation.physics import MakePhysics, QuantityLayout
from pirate_sm.simulation.pipe_changes import PipeChanges
from pirate_sm.simulation.sensors import BoardChannels, sensors_of
from pirate_sm.simulation.surroundings import NO_JITTER, Jitter, surroundings_of

_TOUCHING_N = 0.05
# How often, in cycles, it is looked whether the robot has left the pipe.
_GONE_EVERY = 16
# Beyond this distance from the pipe's open end, a robot that has left it lies somewhere.
_GONE_M = 0.4


class Turn(NamedTuple):
    """What one cycle reads.

    Attributes:
        board: Of which board.
        first: First row of the channel table that is read; likewise ``last``, excluded.
    """

    board: BoardChannels
    first: int
    last: int

    @property
    def channel(self) -> int:
        """Number of the first channel read, in its board."""
        return self.first - self.board.first


class SimulatedRobot:
    """A robot in a pipe that exists only in here.

    Args:
        profile: The robot.
        pipe: Where it is.
        physics: Makes what moves it.
        seed: Of everything that is random; equal seeds give equal runs.
        start_values: Setpoints of the configuration that it starts in, one per slot, for a start
            with clamped parts; None for a straight robot.
        jitter: How far start, friction and diameter may differ from the files.
        defects: Names of the profile's defects to switch on.
        more_defects: Further defects.

    Attributes:
        electronics: Its boards.
        gone: Whether it has left the pipe for good.

    Raises:
        UsageError: It does not fit: the robot into the pipe, the pipe into itself, a defect's
            name to the profile.
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
    ) -> None:
        chain = chain_of(profile)
        routes, sensors = routes_of(profile, chain), sensors_of(profile, chain)
        self._start_duties = _joint_duties(chain, routes, start_values)
        rng = np.random.default_rng(seed)
        duties = self._start_duties
        around = surroundings_of(profile, chain, pipe, duties=duties, jitter=jitter, rng=rng)
        self._route, self._chain = around.route, chain
        self._cycle_s = profile.link.cycle
        self._physics = physics(chain, around.route, around.friction, around.pose, self._cycle_s)
        self._layout = QuantityLayout(chain.nodes)
        self._arcs = self._physics.quantities[self._layout.block("arc")]
        noise_seed = int(rng.integers(2**63))
        self.electronics = Electronics(chain, routes, sensors, self._physics, noise_seed)
        at_work = [*named(defects, profile.simulation.defects, seed), *more_defects]
        self._effects = put_to_work(at_work, self.electronics)
        self._obstacles = Obstacles(self._physics, chain, around.route, around.obstacles)
        self._changes = PipeChanges(
            self._physics, chain.nodes, pipe, around.friction, around.friction_scale
        )
        self._cycles = 0
        self._time_s = 0.0
        self.gone = False
        self._start_m = self._middle()

    def hold(self) -> None:
        """Drive the joints with the duties that the start pose was wound up with."""
        for motor, duty in self._start_duties.items():
            self._physics.duties[motor] = duty

    def turns(self, one_value: bool) -> tuple[Turn, ...]:
        """Return what the cycles read in turn: a board each, or one value each."""
        boards = self.electronics.boards
        if not one_value:
            return tuple(Turn(each, each.first, each.last) for each in boards)
        return tuple(
            Turn(each, row, row + 1) for each in boards for row in range(each.first, each.last)
        )

    def step(self, now_s: float, turn: Turn) -> Sequence[Incident]:
        """Let a cycle pass and read the turn's channels; return what has happened to the boards."""
        self._cycles += 1
        self._time_s += self._cycle_s
        if not self.gone:
            self._changes.step(self._time_s)
            self._physics.advance()
        self.electronics.read(turn.first, turn.last)
        return self.strike(now_s) if self._effects else ()

    def strike(self, now_s: float) -> Sequence[Incident]:
        """Let the defects act on the robot at this time; return what has happened."""
        incidents = [effect.step(now_s) for effect in self._effects]
        return [incident for incident in incidents if incident is not None]

    @property
    def due_s(self) -> float:
        """When the next defect acts all at once; infinite where none will."""
        return min((effect.due_s for effect in self._effects), default=math.inf)

    def meet_obstacles(self) -> FaultReport | None:
        """Let the robot meet what stands in its way after a cycle; return an impassable bend."""
        fault = self._obstacles.step(self._time_s, self._cycle_s)
        if self._cycles % _GONE_EVERY == 0 and not self.gone:
            self._look_whether_gone()
        return fault

    def read(self, now_s: float, turn: Turn) -> list[float] | None:
        """Return the counts of the turn's channels; None where a defect swallows them."""
        first = turn.board.first
        counts = self.frame(now_s, turn.board)
        return counts[turn.first - first : turn.last - first] if counts is not None else None

    def frame(self, now_s: float, board: BoardChannels) -> list[float] | None:
        """Return the counts of a board's channels; None where a defect swallows them."""
        counts: list[float] | None = self.electronics.counts[board.first : board.last].tolist()
        for effect in self._effects:
            if counts is None:
                return None
            counts = effect.frame(now_s, board.board, board.first, counts)
        return counts

    def delivery(self, now_s: float) -> tuple[bool, bool]:
        """Return whether defects let an array reach the boards, and let its echo go."""
        arrives = echoes = True
        for effect in self._effects:
            delivered, answered = effect.delivery(now_s)
            arrives, echoes = arrives and delivered, echoes and answered
        return arrives, echoes

    def set_values(self, values: Sequence[float]) -> None:
        """Put the setpoints in force, cut to what each slot can take."""
        self.electronics.set_values(self.electronics.cut(values))

    @property
    def truth(self) -> FullTruth:
        """Where the robot really is."""
        return FullTruth(
            wheels=self.wheels,
            wheel_radius_m=self._chain.wheel_radius_m,
            walls=plane.walls(self._route),
            distance_m=self._middle() - self._start_m,
            touching=tuple(press > _TOUCHING_N for press in self.values("press")),
            rolls_rad=tuple(self._physics.rolls()),
            arcs_m=tuple(self.arcs_m),
            bends_rad=tuple(self.values("bend")),
            torques_nm=tuple(self.values("bend_torque")),
            gone=self.gone,
        )

    @property
    def wheels(self) -> tuple[tuple[float, float], ...]:
        """Place of each wheel in the drawing of the pipe, m: of the truth what costs little."""
        return tuple((x, y) for x, y, _ in self._physics.places())

    @property
    def arcs_m(self) -> list[float]:
        """Place of each wheel along the pipe: of the truth what a detector needs often."""
        found: list[float] = self._arcs.tolist()
        return found

    @property
    def crossings_m(self) -> tuple[float, ...]:
        """Where the axes of the pipe cross, along the pipe."""
        return self._route.crossings_m

    @property
    def duties(self) -> tuple[float, ...]:
        """Duties in force, of the joints at each wheel, then of the wheels."""
        return tuple(self._physics.duties.tolist())

    def values(self, quantity: str) -> list[float]:
        """Return a quantity of every wheel after the last cycle, see `physics.QuantityLayout`."""
        found: list[float] = self._physics.quantities[self._layout.block(quantity)].tolist()
        return found

    def _middle(self) -> float:
        arcs = self.arcs_m
        return sum(arcs) / len(arcs)

    def _look_whether_gone(self) -> None:
        """Let a robot far outside the pipe come to rest; nothing moves any more."""
        arcs = self.arcs_m
        self.gone = max(-max(arcs), min(arcs) - self._route.length_m) >= _GONE_M
        if self.gone:
            # It lies on the floor: the accelerometer feels its weight, whichever way it lies.
            for axis, value in (("acc_x", 0.0), ("acc_y", 0.0), ("acc_z", GRAVITY_M_S2)):
                self._physics.quantities[self._layout.at(axis)] = value


def _joint_duties(
    chain: ChainBody, routes: Sequence[SlotRoute], values: Sequence[float] | None
) -> dict[int, float]:
    """Return the duties among these setpoints that bend joints have, by the wheel of the joint."""
    if values is None:
        return {}
    return {
        route.motor: value
        for route, value in zip(routes, values, strict=True)
        if 0 <= route.motor < chain.nodes and value != 0.0
    }
