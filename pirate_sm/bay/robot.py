"""The simulated robot behind the bay: boards that take setpoints and give counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pirate_sm.backends.simulator.defects import make_effects
from pirate_sm.backends.simulator.geometry import Pipe
from pirate_sm.backends.simulator.machine import BoardChannels, machine_of
from pirate_sm.backends.simulator.obstacles import Obstacles
from pirate_sm.backends.simulator.scene import Jitter, scene_of
from pirate_sm.backends.simulator.world import World
from pirate_sm.model.pipe import Pipe as PipeFile
from pirate_sm.model.profile import Profile
from pirate_sm.model.simulation import Defect

_GONE_EVERY = 16
_SPONTANEOUS_DUTY = 0.3


@dataclass(frozen=True)
class Truth:
    """What only a simulator knows.

    Attributes:
        wheels: Place of each wheel in the drawing of the pipe, m.
        arcs_m: Place of each wheel along the pipe.
        distance_m: How far the robot's middle has come along the pipe.
        bends_rad: Angle at each wheel between the links that meet there.
        rolls_rad: Angle of the roll joint, and roll of the part ahead and behind.
        gone: Whether the robot has left the pipe for good.
    """

    wheels: tuple[tuple[float, float], ...]
    arcs_m: tuple[float, ...]
    distance_m: float
    bends_rad: tuple[float, ...]
    rolls_rad: tuple[float, ...]
    gone: bool


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


class Robot:
    """A robot in a pipe, moved by whole cycles of the bus.

    Args:
        profile: The robot.
        pipe: Where it is.
        seed: Of everything random about it.
        defects: Names of the profile's defects.
        extra: Further defects at work.
        start_values: Setpoints of the configuration that it starts in, one per slot.

    Raises:
        UsageError: It does not fit: the robot into the pipe, a defect's name to the profile.
    """

    def __init__(
        self,
        profile: Profile,
        pipe: PipeFile,
        *,
        seed: int,
        defects: Sequence[str] = (),
        extra: Sequence[Defect] = (),
        start_values: Sequence[float] | None = None,
    ) -> None:
        machine = machine_of(profile)
        rng = np.random.default_rng(seed)
        scene = scene_of(
            profile, machine, pipe, start_values=start_values, jitter=Jitter(), rng=rng
        )
        self.world = World(
            machine, Pipe(scene.network), scene.friction, scene.pose,
            cycle_s=profile.link.cycle, seed=int(rng.integers(2**63)),
        )  # fmt: skip
        known = {**profile.simulation.defects, **{f"{i}": each for i, each in enumerate(extra)}}
        names = [*defects, *(f"{i}" for i in range(len(extra)))]
        self._effects = make_effects(names, known, self.world, seed)
        self._obstacles = Obstacles(scene.obstacles)
        self._cycle_s = profile.link.cycle
        self._cycles = 0
        self._start_m = self._middle()

    def turns(self, one_value: bool) -> tuple[Turn, ...]:
        """What the cycles read in turn: a board each, or one value each."""
        boards = self.world.machine.boards
        if not one_value:
            return tuple(Turn(each, each.first, each.last) for each in boards)
        return tuple(
            Turn(each, row, row + 1) for each in boards for row in range(each.first, each.last)
        )

    def step(self, now_s: float, turn: Turn) -> bool:
        """One cycle has passed and the turn's channels are fresh; whether the boards restarted."""
        self._cycles += 1
        self.world.advance(turn.first, turn.last)
        restarted = False
        for effect in self._effects:
            # A restart of the boards is the only thing that a defect reports.
            restarted = effect.step(now_s) is not None or restarted
        self._obstacles.step(self.world, self._cycle_s)
        if self._cycles % _GONE_EVERY == 0:
            self.world.check_gone()
        return restarted

    def read(self, now_s: float, turn: Turn) -> list[float] | None:
        """The counts of the turn's channels; None where a defect swallows them."""
        board, first, last = turn.board
        counts: list[float] | None = self.world.raw[first:last].tolist()
        for effect in self._effects:
            if counts is None:
                return None
            counts = effect.frame(now_s, board, first, counts)
        return counts[turn.first - first : turn.last - first] if counts is not None else None

    def delivery(self, now_s: float) -> tuple[bool, bool]:
        """Whether defects let an array reach the boards, and let its echo go."""
        arrives = echoes = True
        for effect in self._effects:
            delivered, answered = effect.delivery(now_s)
            arrives, echoes = arrives and delivered, echoes and answered
        return arrives, echoes

    def set_values(self, values: Sequence[float]) -> None:
        """The setpoints are in force, cut to what each slot can take."""
        routes = self.world.machine.routes
        self.world.set_values(
            [min(max(value, at.low), at.high) for at, value in zip(routes, values, strict=True)]
        )

    def rest(self) -> None:
        """Every motor without a controller of its own has duty 0."""
        self.world.command[:] = 0.0

    def twitch(self, rng: np.random.Generator) -> None:
        """One motor has a duty that nobody asked for."""
        driven = sorted({at.command for at in self.world.machine.routes if at.command >= 0})
        duty = rng.uniform(-_SPONTANEOUS_DUTY, _SPONTANEOUS_DUTY)
        self.world.command[driven[int(rng.integers(len(driven)))]] = duty

    @property
    def truth(self) -> Truth:
        """Where the robot really is."""
        world = self.world
        return Truth(
            tuple((float(x), float(y)) for x, y in world.state.position),
            tuple(world.arcs()),
            self._middle() - self._start_m,
            tuple(world.state.bend.tolist()),
            tuple(world.state.roll.tolist()),
            world.gone,
        )

    def _middle(self) -> float:
        arcs = self.world.arcs()
        return sum(arcs) / len(arcs)
