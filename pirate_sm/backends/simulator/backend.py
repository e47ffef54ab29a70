"""The simulator behind the backend protocol: arrays in, raw frames and reports out.

One board reports per bus cycle, in turn, as on the real link (thesis section 4-2). An array takes
effect with the next cycle; its echo comes after the profile's delay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pirate_sm.backends.protocol import Completion
from pirate_sm.backends.simulator.defects import make_effects
from pirate_sm.backends.simulator.geometry import Pipe
from pirate_sm.backends.simulator.machine import machine_of
from pirate_sm.backends.simulator.obstacles import Obstacles
from pirate_sm.backends.simulator.scene import Jitter, scene_of
from pirate_sm.backends.simulator.world import World
from pirate_sm.errors import BackendError
from pirate_sm.model.events import Event, SensorFrame, SubmitResult
from pirate_sm.model.pipe import Pipe as PipeFile
from pirate_sm.model.profile import Profile

# How often, in cycles, it is looked whether the robot has left the pipe.
_GONE_EVERY = 16
# With a silent robot `advance` still returns this often.
_SILENCE_S = 1.0
_TOUCHING_N = 0.05


@dataclass(frozen=True)
class Truth:
    """What only a simulator knows, for a view and the end of a run.

    Attributes:
        wheels: Place of each wheel in the drawing of the pipe, m.
        touching: Whether each wheel presses on a wall.
        wheel_radius_m: Of the wheels.
        walls: Corners of the walls on side A and on side B, m.
        arcs_m: Place of each wheel along the pipe.
        distance_m: How far the robot's middle has come along the pipe.
        torques_nm: What the bend joint at each wheel bears; 0 where there is none.
        rolls_rad: Angle of the roll joint, and roll of the part ahead and of the part behind.
        gone: Whether the robot has left the pipe.
    """

    wheels: tuple[tuple[float, float], ...]
    touching: tuple[bool, ...]
    wheel_radius_m: float
    walls: tuple[tuple[tuple[float, float], ...], tuple[tuple[float, float], ...]]
    arcs_m: tuple[float, ...]
    distance_m: float
    torques_nm: tuple[float, ...]
    rolls_rad: tuple[float, ...]
    gone: bool


class _Sent(NamedTuple):
    """An array on its way."""

    setpoint_id: int
    values: tuple[float, ...]
    arrives: bool


@dataclass
class _Wire:
    """What is on its way: an array that waits for the next cycle, and results to be told."""

    waiting: _Sent | None = None
    results: list[tuple[float, SubmitResult]] = field(default_factory=list)

    @property
    def due_s(self) -> float:
        """When the next result is to be told."""
        return min([due for due, _ in self.results]) if self.results else math.inf

    def take(self, now: float) -> list[Event]:
        """The results that are due, oldest first."""
        due = [result for at, result in self.results if at <= now]
        self.results = [(at, result) for at, result in self.results if at > now]
        return list(due)


class SimulatorBackend:
    """A robot in a pipe that exists only in here.

    Args:
        profile: The robot.
        pipe: Where it is.
        seed: Of everything that is random; equal seeds give equal runs.
        start_values: Setpoints of the configuration that it starts in, one per slot, for a start
            with clamped parts; None for a straight robot.
        jitter: How far start, friction and diameter may differ from the files.
        defects: Names of the profile's defects to switch on.

    Raises:
        UsageError: It does not fit: the robot into the pipe, the pipe into itself, a defect's
            name to the profile.
    """

    name = "sim"
    completion: Completion = "measured"
    real_time = False

    def __init__(
        self,
        profile: Profile,
        pipe: PipeFile,
        *,
        seed: int = 0,
        start_values: Sequence[float] | None = None,
        jitter: Jitter | None = None,
        defects: Sequence[str] = (),
    ) -> None:
        link = profile.link
        machine = machine_of(profile)
        rng = np.random.default_rng(seed)
        scene = scene_of(
            profile, machine, pipe,
            start_values=start_values, jitter=jitter or Jitter(), rng=rng,
        )  # fmt: skip
        self._cycle_s = link.cycle
        self._echo_s = link.echo_delay
        self._unknown_s = link.resend_after
        self._world = World(
            machine, Pipe(scene.network), scene.friction, scene.pose,
            cycle_s=link.cycle, seed=int(rng.integers(2**63)),
        )  # fmt: skip
        # A robot that starts clamped is held there by its motors.
        for joint, duty in scene.pose.duties.items():
            self._world.command[joint] = duty
        self._obstacles = Obstacles(scene.obstacles)
        self._effects = make_effects(defects, profile.simulation.defects, self._world, seed)
        self._one_value = link.state_message == "value"
        # What is read in each cycle in turn: (board, first row, last row, rows of the board).
        self._turns = tuple(
            (board.board, row, row + 1 if self._one_value else board.last, board)
            for board in machine.boards
            for row in (range(board.first, board.last) if self._one_value else (board.first,))
        )
        self._wire = _Wire()
        self._now = 0.0
        self._cycles = 0
        self._closed = False
        self._start = self._middle()

    @property
    def truth(self) -> Truth:
        """Where the robot really is."""
        world = self._world
        places = [(float(x), float(y)) for x, y in world.state.position]
        return Truth(
            tuple(places),
            tuple(press > _TOUCHING_N for press in world.values("press")),
            world.machine.chain.wheel_radius_m,
            (world.pipe.wall_a, world.pipe.wall_b),
            tuple(world.arcs()),
            self._middle() - self._start,
            tuple(world.values("bend_torque")),
            tuple(world.state.roll.tolist()),
            world.gone,
        )

    @property
    def wheels(self) -> tuple[tuple[float, float], ...]:
        """Place of each wheel in the drawing of the pipe, m: of the truth what costs little."""
        return tuple((x, y) for x, y in self._world.state.position.tolist())

    @property
    def arcs_m(self) -> list[float]:
        """Place of each wheel along the pipe: of the truth what a detector needs often."""
        return self._world.arcs()

    @property
    def crossings_m(self) -> tuple[float, ...]:
        """Where the axes of the pipe cross, along the pipe."""
        return self._world.pipe.crossings_m

    def _middle(self) -> float:
        arcs = self._world.arcs()
        return sum(arcs) / len(arcs)

    def open(self) -> Sequence[Event]:
        """Every board has reported once."""
        events: list[Event] = []
        for board in self._world.machine.boards:
            events += self._frame(board.board, board.first, board.last)
        return events

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """The array is in force from the next cycle on, unless it is lost or refused.

        Raises:
            BackendError: The simulator has been closed.
        """
        if self._closed:
            raise BackendError("the simulator is closed")
        refusal = self._world.refusal(values)
        if refusal:
            self._tell(self._now, SubmitResult(setpoint_id, "rejected", refusal))
            return
        older = self._wire.waiting
        if older is not None:
            reason = f"array {setpoint_id} came before it was sent"
            self._supersede(older.setpoint_id, reason)
        arrives = echoes = True
        for effect in self._effects:
            delivered, answered = effect.delivery(self._now)
            arrives, echoes = arrives and delivered, echoes and answered
        self._wire.waiting = _Sent(setpoint_id, values, arrives)
        if arrives and echoes:
            self._tell(self._now + self._echo_s, SubmitResult(setpoint_id, "accepted"))
        else:
            lost = SubmitResult(setpoint_id, "unknown", "no echo came")
            self._tell(self._now + self._unknown_s, lost)

    def _tell(self, due_s: float, result: SubmitResult) -> None:
        self._wire.results.append((due_s, result))

    def _supersede(self, setpoint_id: int, reason: str) -> None:
        results = self._wire.results
        last = max(i for i, (_, r) in enumerate(results) if r.setpoint_id == setpoint_id)
        results[last] = (self._now, SubmitResult(setpoint_id, "superseded", reason))

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """The world has run until `until_s` or the first moment with an event."""
        quiet_until = self._now + _SILENCE_S
        while True:
            cycle = (self._cycles + 1) * self._cycle_s
            due = min(cycle, self._wire.due_s)
            if due > until_s:
                self._now = max(self._now, until_s)
                return self._now, ()
            self._now = max(self._now, due)
            events: list[Event] = self._wire.take(self._now) if self._wire.results else []
            if cycle <= self._now:
                events += self._cycle()
            if events or self._now >= quiet_until:
                return self._now, events

    def _cycle(self) -> list[Event]:
        """One cycle of the bus has passed."""
        world = self._world
        waiting = self._wire.waiting
        if waiting is not None:
            self._wire.waiting = None
            if waiting.arrives:
                world.set_values(waiting.values)
        self._cycles += 1
        turn = self._turns[self._cycles % len(self._turns)]
        world.advance(turn[1], turn[2])
        events: list[Event] = []
        for effect in self._effects:
            fault = effect.step(self._now)
            if fault is not None:
                events.append(fault)
        if turn[2] == turn[3].last:  # values that come one by one are reported when all have come
            events += self._frame(turn[0], turn[3].first, turn[3].last)
        fault = self._obstacles.step(world, self._cycle_s)
        if fault is not None:
            events.append(fault)
        if self._cycles % _GONE_EVERY == 0:
            world.check_gone()
        return events

    def _frame(self, board: int, first: int, last: int) -> list[Event]:
        counts: list[float] | None = self._world.raw[first:last].tolist()
        for effect in self._effects:
            if counts is None:
                break
            counts = effect.frame(self._now, board, first, counts)
        return [SensorFrame(board, tuple(counts))] if counts is not None else []

    def close(self) -> None:
        """The last array submitted is in force; nothing more is taken."""
        waiting = self._wire.waiting
        self._wire.waiting = None
        self._closed = True
        if waiting is not None and waiting.arrives:
            self._world.set_values(waiting.values)
