"""Lets cycles of a simulated robot pass in one compiled call, for one engine."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from pirate_sm.core.effects import WakeAt
from pirate_sm.core.events import DetectorWord, FrameBlock, SensorFrame, Tick, Trail, WordWatch
from pirate_sm.core.expressions import DEEPEST
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import Glide, Glided, MotorRequest, Step, Watch, ask
from pirate_sm.simulation.arrays import Floats, Ints
from pirate_sm.simulation.gliding.columns import TICK_COLUMNS, U_REPORTS
from pirate_sm.simulation.gliding.tables import (
    LookTables,
    SignalTables,
    SurveyTables,
    WatchTables,
    robot_tables,
)
from pirate_sm.simulation.physics import GlidingPhysics
from pirate_sm.simulation.simulated_robot import CycleReading, SimulatedRobot

_MOST_FRAMES, _MOST_TICKS = 256, 64
"""How many frames one call may take, and how often it may look for silent boards."""


class Passed(NamedTuple):
    """What has passed in one call.

    Attributes:
        glide: What the engine must know.
        cycles: How many cycles have passed, in all.
        waiting: A frame that waits for the engine; None without one.
        met: Whether the surroundings must act on the robot.
    """

    glide: Glide
    cycles: int
    waiting: SensorFrame | None
    met: bool


class Glider:
    """Lets cycles pass, for an engine that knows the robot.

    Args:
        robot: The robot as the engine knows it.
        simulated: The simulated robot.
        turns: The turns of the cycles.
        cycle_s: Duration of a cycle.
    """

    def __init__(
        self,
        robot: RobotSpec,
        simulated: SimulatedRobot,
        turns: Sequence[CycleReading],
        cycle_s: float,
    ) -> None:
        self.robot = robot
        self._cycle_s = cycle_s
        self._simulated = simulated
        physics = simulated.physics
        self._physics = physics if isinstance(physics, GlidingPhysics) else None
        electronics = simulated.electronics
        self._electronics = electronics
        self._tables = robot_tables(robot, electronics.boards)
        self._ids = [each.id for each in sorted(robot.boards.values(), key=lambda b: b.position)]
        self._widths = {each.board: each.last - each.first for each in electronics.boards}
        self._signals = SignalTables(robot)
        self._watch = WatchTables(len(robot.vocabulary.numbers))
        self._survey = SurveyTables(robot)
        self._looks = LookTables(len(simulated.arcs))
        self._around: Floats = np.full(1 + len(simulated.leeway), cycle_s)
        self._turns = _turn_table(robot, turns)
        ends: list[int] = self._turns[:, U_REPORTS].tolist() * 2
        self._to_report: list[int] = [ends.index(1, at + 1) - at for at in range(len(self._turns))]
        self._forced: Floats = np.full(len(electronics.counts), nan)
        self._shown: dict[int, float] = {}
        self._clock: Floats = np.zeros(6)
        self._ticks: Floats = np.zeros((_MOST_TICKS, TICK_COLUMNS))
        self._scratch = np.zeros_like(self._signals.signals), np.zeros(DEEPEST)
        self._times_s: Floats = np.zeros(_MOST_FRAMES)
        self._reporters: Ints = np.zeros(_MOST_FRAMES + 1, dtype=np.int64)
        width = max(self._widths.values(), default=0)
        self._reports: Floats = np.zeros((_MOST_FRAMES + 1, width))
        self._met: Ints = np.zeros(5, dtype=np.int64)
        # No call passes more cycles: boards are looked for long before.
        rows = (_MOST_FRAMES + 1) * max(1, len(self._turns))
        self._trail: Floats = np.zeros((rows, simulated.trail_columns))

    def glide(
        self, watch: Watch, words: WordWatch | None, now_s: float, cycles: int, until_s: float
    ) -> Passed | None:
        """Let cycles pass while frames are quiet.

        Args:
            watch: What must stay true.
            words: What a detector knows that is to be relieved; None without one.
            now_s: The time.
            cycles: How many cycles have passed, in all.
            until_s: When time stops.

        Returns:
            What has passed; None if no cycle may pass.
        """
        simulated, physics = self._simulated, self._physics
        until_s = min(until_s, simulated.glides_until_s(now_s))
        if (
            self._tables is None
            or physics is None
            or (cycles + 1) * self._cycle_s >= min(until_s, watch.alarm_s)
        ):
            return None
        asked = ask(self.robot, watch.sensing.asked, watch.asked, self._next_frame_s(cycles))
        if not (self._watch.take(watch, until_s) and self._looks.take(words, watch)):
            return None
        self._signals.take(watch, asked)
        self._survey.take(watch)
        self._force(now_s)
        times = watch.sensing.checked_s, watch.listening_s, watch.word_until_s
        self._clock[:] = now_s, cycles, simulated.time_s, *times
        self._around[1:] = simulated.leeway
        self._met[:] = 0
        physics.glide(*self._arguments(physics))
        return self._passed(watch, asked, words, cycles)

    def _force(self, now_s: float) -> None:
        """Show what defects show instead of what is measured."""
        forced = self._simulated.forced(now_s)
        if forced != self._shown:
            self._shown = forced
            self._forced[:] = nan
            for row, shown in forced.items():
                self._forced[row] = shown

    def _arguments(self, physics: GlidingPhysics) -> tuple[Any, ...]:
        electronics, signals, watch = self._electronics, self._signals, self._watch
        simulated = self._simulated
        assert self._tables is not None  # glide has looked
        return (
            (simulated.physics.quantities, physics.roll_angles, simulated.arcs, self._around),
            self._turns,
            (electronics.channels, electronics.counts, electronics.rng, self._forced),
            self._tables,
            watch.arrays,
            *(self._clock, signals.signals, self._scratch),
            *(self._survey.arrays, self._looks.arrays),
            (self._times_s, self._reporters, self._reports, self._ticks, self._met),
            self._trail,
        )

    def _next_frame_s(self, cycles: int) -> float:
        """Return when the next board reports."""
        return (cycles + self._to_report[cycles % len(self._to_report)]) * self._cycle_s

    def _passed(
        self, watch: Watch, asked: MotorRequest, words: WordWatch | None, before: int
    ) -> Passed:
        now_s, cycles, time_s, checked_s, _, word_s = self._clock.tolist()
        count, waits, position, met, looked = self._met.tolist()
        positions: list[int] = self._reporters[:count].tolist()
        frames = self._block(positions)
        waiting = None
        if waits:
            board = self._ids[position]
            values = self._reports[count, : self._widths[board]].tolist()
            waiting = SensorFrame(board, tuple(values))
        self._simulated.glided(round(cycles) - before, time_s, frames, waiting)
        rows: list[list[float]] = self._ticks[:looked].tolist()
        wake_s = next((row[1] for row in reversed(rows) if row[1] < inf), watch.wake_s)
        after = None
        if count or rows:
            asked = asked if count else watch.sensing.asked
            sensing = self._signals.given(watch.sensing, positions, asked, checked_s)
            after = Glided(sensing, self._survey.given(), wake_s, word_s)
        said_s = next((row[0] for row in reversed(rows) if row[1] == inf), None)
        steps = [_step(frames, row, words) for row in rows]
        looks, due_s = self._looks.made()
        trail = Trail(now_s, self._noted, self._simulated.whereabouts)
        glide = Glide(now_s, after, frames, steps, looks, due_s, said_s, trail)
        return Passed(glide, round(cycles), waiting, bool(met))

    def _noted(self, times_s: Sequence[float]) -> bytes:
        """Return the rows of the trail for these times of the last call."""
        trail, rows = self._trail, len(self._trail)
        return b"".join([trail[self._cycle_at(at_s) % rows].tobytes() for at_s in times_s])

    def _cycle_at(self, at_s: float) -> int:
        """Return how many cycles had passed at a time, in all."""
        cycle = int(at_s / self._cycle_s)
        while (cycle + 1) * self._cycle_s <= at_s:
            cycle += 1
        while cycle * self._cycle_s > at_s:
            cycle -= 1
        return cycle

    def _block(self, positions: Sequence[int]) -> FrameBlock:
        count, boards = len(positions), [self._ids[position] for position in positions]
        times_s: list[float] = self._times_s[:count].tolist()
        return FrameBlock(times_s, boards, self._reports[:count].copy(), self._widths)


def _step(frames: FrameBlock, row: Sequence[float], words: WordWatch | None) -> Step:
    """Return what has happened: a word was repeated, or silent boards were looked for."""
    at_s, wake_s, of_frame = row
    if wake_s == inf and words is not None:
        return at_s, DetectorWord(words.name, words.valid_for_s), ()
    event = frames.frame(bisect_left(frames.times_s, at_s)) if of_frame else Tick()
    return at_s, event, (WakeAt(wake_s),)


def _turn_table(robot: RobotSpec, turns: Sequence[CycleReading]) -> Ints:
    """Return which channels each cycle reads, and whose board reports after it."""
    rows = [
        (
            robot.boards[turn.board.board].position,
            turn.first,
            turn.last,
            turn.last == turn.board.last,
        )
        for turn in turns
        if turn.board.board in robot.boards
    ]
    return np.array(rows, dtype=np.int64).reshape(-1, 4)
