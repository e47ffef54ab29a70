"""Compile what the boards of a robot report, and what follows from it, to a table of signals."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from math import inf, nan
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing.board_spec import BoardSpec
from pirate_sm.core._engine.sensing.known_signals import MotorRequest, Sensing
from pirate_sm.core._engine.sensing.plausibility_spec import WatchedSpec, WatchSpec
from pirate_sm.core._engine.signals import evaluator as op

Row: TypeAlias = tuple[int, int, int, int, int]
Rows: TypeAlias = tuple[Row, ...]


_OPERATIONS = {
    **{"rate": op.RATE, "torque": op.TORQUE, "diameter": op.DIAMETER},
    **{"norm": op.NORM, "roll": op.ROLL, "pitch": op.PITCH},
}


class BoardRows(NamedTuple):
    """The rows of a board's frame.

    ``whole`` is all of them: what it measures, the limits of that, two comparisons of motions with
    what was asked, and what follows.
    """

    whole: Rows
    measured: Rows
    stuck: Rows
    rest: Rows
    derived: Rows


class Layout(NamedTuple):
    """Where the cells are, of which the signals are the first.

    Attributes:
        heard: Per board when it last reported.
        shares: Per wheel its share of the odometry; ``angles``: what its sensor last showed.
        motion: Per sensor of a motion what is remembered, see `evaluator.UNMOVED`.
        loss: Share of lost reports.
        force: Setpoints in force per slot; ``latest``: those last sent.
        asked: When the latest were asked, ``driving``: whether they drive wheels.
        out: Per wheel whether it is not believed.
        constants: The others, which nothing changes.
    """

    heard: int
    shares: int
    angles: int
    motion: int
    loss: int
    force: int
    latest: int
    asked: int
    driving: int
    out: int
    constants: int


class SignalTable(NamedTuple):
    """The table of a robot.

    Attributes:
        boards: Per board by its position.
        lists: Operands of which there are many.
        constants: The last cells.
        believed: The cells that say that every wheel is believed.
    """

    layout: Layout
    boards: tuple[BoardRows, ...]
    lists: tuple[int, ...]
    constants: tuple[float, ...]
    believed: tuple[float, ...]

    def cells(
        self,
        sensing: Sensing,
        force: Numbers = (),
        latest: Numbers = (),
        asked: MotorRequest | None = None,
    ) -> list[float]:
        """Return the cells before a frame.

        Args:
            sensing: The signals.
            force: The setpoints in force per slot; without any they are unknown.
            latest: Those last sent.
            asked: What they ask of the motors; by default what they did before.
        """
        if not force:
            force = latest = (nan,) * (self.layout.latest - self.layout.force)
        asked = sensing.asked if asked is None else asked
        out = sensing.distance.out
        return [
            *(*sensing.numbers, *sensing.heard_s, *sensing.shares, *sensing.angles),
            *(*sensing.motion, sensing.loss, *force, *latest),
            *(asked.since_s if asked.setpoints else inf, asked.driving),
            *([place in out for place in range(len(sensing.shares))] if out else self.believed),
            *self.constants,
        ]


@lru_cache(maxsize=16)
def signal_table(robot: RobotSpec) -> SignalTable:
    """Return the table of a robot, which all its engines share."""
    return _Compiler(robot).table()


class _Compiler:
    """Writes the rows of a robot."""

    def __init__(self, robot: RobotSpec) -> None:
        self._robot = robot
        wheels, slots = len(robot.wheels), len(robot.slots)
        at, begins = len(robot.vocabulary.numbers), []
        moving = sum(len(board.watched.moving) for board in robot.boards.values())
        motion = moving * len(op.UNMOVED)
        for length in (len(robot.boards), wheels, wheels, motion, 1, slots, slots, 1, 1, wheels):
            begins.append(at)
            at += length
        self._layout = Layout._make([*begins, at])
        self._constants: list[float] = []
        self._lists = self._wheels()
        self._remembered = self._layout.motion

    def table(self) -> SignalTable:
        """Return the table."""
        boards = sorted(self._robot.boards.values(), key=lambda each: each.position)
        rows = tuple(self._board(each) for each in boards)
        believed = (0.0,) * len(self._robot.wheels)
        return SignalTable(self._layout, rows, tuple(self._lists), tuple(self._constants), believed)

    def _constant(self, value: float) -> int:
        """Return the cell of a constant."""
        if value not in self._constants:
            self._constants.append(value)
        return self._layout.constants + self._constants.index(value)

    def _wheels(self) -> list[int]:
        """Return the description of all wheels, see `evaluator.WHEEL`."""
        layout, robot = self._layout, self._robot
        unheard = self._constant(-inf)  # of a wheel that no board reports
        found = [len(robot.wheels), self._constant(robot.link.silent_after_s)]
        for wheel, board in zip(robot.wheels, robot.wheel_boards, strict=True):
            found += (
                *(wheel.angle, wheel.speed, layout.angles + wheel.place),
                layout.shares + wheel.place,
                layout.heard + board if board >= 0 else unheard,
                *(layout.out + wheel.place, self._constant(wheel.metres_per_rad)),
                *(layout.force + wheel.slot, layout.latest + wheel.slot),
            )
        return found

    def _board(self, board: BoardSpec) -> BoardRows:
        zeros, constant = dict(board.zeros), self._constant
        measured = [
            (op.SCALE, target, place, constant(scale), constant(zeros.get(target, 0.0)))
            for place, target, scale in board.channels
        ]
        stuck, rest = [], []
        for place in board.watched.moving:
            watch, memory = board.watched.sensors[place], self._remembered
            at, self._remembered = self._motion(watch), memory + len(op.UNMOVED)
            if watch.load >= 0:
                stuck.append((op.STUCK, watch.number, memory, at, place))
            rest.append((op.REST, watch.number, memory, at, place))
        limits, derived = self._limits(board.watched), tuple(self._derived(board))
        whole = *measured, *limits, *stuck, *rest, *derived
        return BoardRows(whole, tuple(measured), tuple(stuck), tuple(rest), derived)

    def _motion(self, watch: WatchSpec) -> int:
        """Return where it says by what a sensor is judged, see `evaluator.MOTION`."""
        layout, spec, at = self._layout, self._robot.plausibility, len(self._lists)
        limits = watch.least_duty, spec.unloaded, watch.full_load, spec.stuck_after_s
        resting = watch.moved, spec.moved_readings, spec.settle_s
        self._lists += (
            *(layout.latest + watch.slot, max(watch.load, 0)),
            *(self._constant(float(limit)) for limit in (*limits, *resting)),
            *(layout.asked, layout.driving),
        )
        return at

    def _limits(self, watched: WatchedSpec) -> Iterable[Row]:
        for number, low, high in watched.ranges:
            yield op.RANGE, number, 0, self._constant(low), self._constant(high)
        for number, rate, slack in watched.rates:
            yield op.STEP, number, 0, self._constant(rate), self._constant(slack)

    def _derived(self, board: BoardSpec) -> Iterable[Row]:
        robot, layout, constant = self._robot, self._layout, self._constant
        for each in board.derived:
            a, b, c = (*each.sources, 0, 0)[:3]
            if each.how == "torque":
                b, c = layout.force + each.slot, constant(each.factor)
            elif each.how == "diameter":
                b, c = constant(each.factor), constant(each.more)
            yield _OPERATIONS[each.how], each.target, a, b, c
        places = [wheel.place for wheel in robot.wheels]
        for wheel in board.wheels:
            at = 2 + places.index(wheel.place) * op.WHEEL
            yield op.ODOMETRY, robot.odometry, at, 0, 0
        if board.wheels and robot.speed >= 0:
            yield op.SPEED, robot.speed, 0, 0, 0
        yield op.LOSS, layout.loss, constant(robot.link.period_s), 0, 0
        yield op.HEARD, layout.heard + board.position, 0, 0, 0
