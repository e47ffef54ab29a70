"""The simulator behind the backend protocol: arrays in, raw frames and reports out.

One board reports per bus cycle, in turn, as on the real link (thesis section 4-2). An array takes
effect in the next cycle, and its echo comes after the profile's delay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import (
    BuiltInFault,
    Event,
    FaultReport,
    SensorFrame,
    SubmitResult,
    SubmitStatus,
    WordWatch,
)
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.sensing import Glide, Watch
from pirate_sm.robot.backends.protocol import Completion
from pirate_sm.simulation.acting_defect import Incident
from pirate_sm.simulation.electronics import BoardChannels
from pirate_sm.simulation.gliding.glider import Glider
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.physics import MakePhysics
from pirate_sm.simulation.simulated_robot import FullTruth, SimulatedRobot
from pirate_sm.simulation.standing import Standing
from pirate_sm.simulation.surroundings import NO_JITTER, Jitter

# `advance` returns after this time even if the robot reports nothing.
_SILENCE_S = 1.0


@dataclass(frozen=True, slots=True)
class _Order:
    """An array that has been submitted.

    Attributes:
        number: How many had been submitted with it.
        given_up_s: When its result is unknown if no echo has come.
    """

    number: int
    setpoint_id: int
    values: tuple[float, ...]
    given_up_s: float

    def result(self, status: SubmitStatus, reason: str = "") -> SubmitResult:
        """Return a result of it."""
        return SubmitResult(self.setpoint_id, status, reason)


@dataclass
class _Wire:
    """The arrays on their way, and results that wait to be reported.

    Attributes:
        waiting: The array that waits for the next cycle, and whether it arrives.
        overdue: When the array is written again whose echo does not come, and that array.
        results: When the result of each order is reported, and the result, by the order's number.
    """

    waiting: tuple[_Order, bool] | None = None
    overdue: tuple[float, _Order] | None = None
    results: dict[int, tuple[float, SubmitResult]] = field(default_factory=dict)

    @property
    def due_s(self) -> float:
        """When the next result or the next copy of an array is due."""
        due_s = min([due for due, _ in self.results.values()]) if self.results else math.inf
        return due_s if self.overdue is None else min(due_s, self.overdue[0])

    def take(self, now: float) -> list[Event]:
        """Return the results that are due, oldest first."""
        due = [result for at, result in self.results.values() if at <= now]
        self.results = {order: it for order, it in self.results.items() if it[0] > now}
        return list(due)

    def arriving(self) -> tuple[float, ...] | None:
        """Return the array that comes into force in the next cycle; None without one."""
        return self.waiting[0].values if self.waiting is not None and self.waiting[1] else None


class SimulatorBackend:
    """Simulates a robot in a pipe.

    Args:
        profile: The robot's profile.
        pipe: The pipe.
        seed: Seed of all random numbers; equal seeds give equal runs.
        start_values: Setpoints of the configuration at the start, one per slot, for a start with
            clamped parts; None for a straight robot.
        jitter: How far start, friction and diameter may differ from the files.
        defects: Which of the profile's defects to switch on, as text with their numbers.
        put_back: How the robot stands, instead of where its pipe says; None: there.
        physics: Makes the physics that moves the robot.
        name: Name of the backend with this physics.

    Attributes:
        robot: The robot as it truly is, for whoever measures.

    Raises:
        UsageError: The robot does not fit into the pipe, the pipe intersects itself, or the
            profile has no such defect.
    """

    completion: Completion = "measured"
    real_time = False

    def __init__(
        self,
        profile: Profile,
        pipe: Pipe,
        *,
        seed: int = 0,
        start_values: Sequence[float] | None = None,
        jitter: Jitter = NO_JITTER,
        defects: Sequence[str] = (),
        put_back: Standing | None = None,
        physics: MakePhysics = kinematic,
        name: str = "sim",
    ) -> None:
        self.name = name
        link = profile.link
        self._cycle_s = link.cycle
        self._echo_s = link.echo_delay
        self._unknown_s = link.resend_after
        # The driver of the robot writes an array again when its echo is overdue; the thesis's node
        # sent every message twice, 100 ms apart, with echoes after 50 ms [4-2-2].
        self._overdue_s = max(2 * link.echo_delay, link.cycle)
        self.robot = SimulatedRobot(
            profile,
            pipe,
            physics,
            seed=seed,
            start_values=start_values,
            jitter=jitter,
            defects=defects,
            put_back=put_back,
        )
        # A robot that starts clamped is held there by its motors.
        self.robot.hold()
        self._turns = self.robot.turns(link.state_message == "value")
        self._wire = _Wire()
        self._orders = 0
        self._now = 0.0
        self._cycles = 0
        self._closed = False
        self._pending: list[Event] = []
        self._glider: Glider | None = None

    @property
    def truth(self) -> FullTruth:
        """The robot's true position and state."""
        return self.robot.truth

    def places_m(self) -> list[float]:
        """Return the position of each wheel along the pipe, m; cheaper than ``truth``."""
        return self.robot.arcs_m

    @property
    def moved_until_s(self) -> float:
        """Until when the robot has moved: the end of the last cycle."""
        return self._cycles * self._cycle_s

    def open(self) -> Sequence[Event]:
        """Return the first report of every board."""
        events: list[Event] = []
        for board in self.robot.electronics.boards:
            events += self._frame(board)
        return events

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Put the array in force from the next cycle on, unless it is lost or rejected.

        Raises:
            BackendError: The simulator has been closed.
        """
        if self._closed:
            raise BackendError("the simulator is closed")
        self._orders += 1
        order = _Order(self._orders, setpoint_id, values, self._now + self._unknown_s)
        refusal = self.robot.electronics.refusal(values)
        if refusal:
            self._wire.results[order.number] = self._now, order.result("rejected", refusal)
            return
        if self._wire.waiting is not None:
            older, _ = self._wire.waiting
            reason = f"array {setpoint_id} came before it was sent"
            self._wire.results[older.number] = self._now, older.result("superseded", reason)
        self._write(order)

    def _write(self, order: _Order) -> None:
        """Write the array, and again when its echo is overdue, until it is given up."""
        wire = self._wire
        arrives, echoes = self.robot.delivery(self._now)
        wire.waiting, wire.overdue = (order, arrives), None
        if arrives and echoes:
            wire.results[order.number] = self._now + self._echo_s, order.result("accepted")
            return
        wire.results[order.number] = order.given_up_s, order.result("unknown", "no echo came")
        again_s = self._now + self._overdue_s
        if again_s + self._echo_s <= order.given_up_s:
            wire.overdue = again_s, order

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Let the robot run until `until_s` or the first moment with an event."""
        if self._pending:
            pending, self._pending = self._pending, []
            return self._now, pending
        quiet_until = self._now + _SILENCE_S
        while True:
            cycle = (self._cycles + 1) * self._cycle_s
            due = min(cycle, self._wire.due_s)
            if due > until_s:
                self._now = max(self._now, until_s)
                return self._now, ()
            self._now = max(self._now, due)
            if self._wire.overdue is not None and self._wire.overdue[0] <= self._now:
                self._write(self._wire.overdue[1])
            events: list[Event] = self._wire.take(self._now) if self._wire.results else []
            if cycle <= self._now:
                events += self._cycle()
            if events or self._now >= quiet_until:
                return self._now, events

    def glide(self, watch: Watch, until_s: float, words: WordWatch | None = None) -> Glide | None:
        """Let cycles pass as long as their frames change nothing but signals."""
        if self._closed or self._pending:
            return None
        if self._glider is None or self._glider.robot is not watch.robot:
            self._glider = Glider(watch.robot, self.robot, self._turns, self._cycle_s)
        until_s, arriving = min(until_s, self._wire.due_s), self._wire.arriving()
        if arriving is not None:  # in force from the next cycle on, if it comes
            self.robot.electronics.set_values(arriving)
        passed = self._glider.glide(watch, words, self._now, self._cycles, until_s)
        if passed is None:
            return None
        if passed.cycles > self._cycles:
            self._wire.waiting = None
        self._now, self._cycles = passed.glide.now_s, passed.cycles
        if passed.waiting is not None:
            self._pending.append(passed.waiting)
        fault = self.robot.meet_obstacles() if passed.met else None
        if fault is not None:
            self._pending.append(fault)
        return passed.glide

    def _cycle(self) -> list[Event]:
        """Simulate one cycle of the bus."""
        robot = self.robot
        arriving, self._wire.waiting = self._wire.arriving(), None
        if arriving is not None:
            robot.electronics.set_values(arriving)
        self._cycles += 1
        turn = self._turns[self._cycles % len(self._turns)]
        events: list[Event] = []
        for incident in robot.step(self._now, turn):
            events += self._react_to(incident)
        board = turn.board
        if turn.last == board.last:  # single values are reported when all have come
            events += self._frame(board)
        fault = robot.meet_obstacles()
        if fault is not None:
            events.append(fault)
        return events

    def _react_to(self, incident: Incident) -> Sequence[Event]:
        """Return the faults that follow at once from an incident on the boards."""
        if incident.what == "boards_restarted":
            return (BuiltInFault.FIRMWARE_RESET.report("the boards have started again", 0.0),)
        if incident.what == "controller_restarted":
            return (self._start_again(incident.until_s),)
        return ()

    def _start_again(self, until_s: float) -> FaultReport:
        """Simulate until the controller has restarted and writes its setpoints, all zero.

        The motors go on meanwhile. Mission time stands still, as during a silence of the link.
        """
        away_s = until_s - self._now
        for _ in range(round(away_s / self._cycle_s)):
            self.robot.step(self._now, self._turns[0])
            self.robot.meet_obstacles()
        self.robot.electronics.rest()
        return BuiltInFault.FIRMWARE_RESET.report("the controller has started again", away_s)

    def _frame(self, board: BoardChannels) -> Sequence[Event]:
        counts = self.robot.frame(self._now, board)
        return (SensorFrame(board.board, tuple(counts)),) if counts is not None else ()

    def close(self) -> None:
        """Put the last submitted array in force and take no more."""
        if self._wire.overdue is not None:
            self._write(self._wire.overdue[1])
        arriving, self._wire.waiting = self._wire.arriving(), None
        self._closed = True
        if arriving is not None:
            self.robot.electronics.set_values(arriving)
