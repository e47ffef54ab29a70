"""Apply frames of boards by a table that is compiled once, and forget signals that are too old."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import lru_cache
from math import inf, isnan, nan
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing import evaluator as op
from pirate_sm.core._engine.sensing import plausibility
from pirate_sm.core._engine.sensing.board_spec import BoardSpec, WatchedSpec, WatchSpec
from pirate_sm.core._engine.sensing.evaluator import run
from pirate_sm.core._engine.sensing.known_signals import MotorRequest, Sensing
from pirate_sm.core._engine.sensing.plausibility import BoardMemory, MotionRows, Reading, Rows
from pirate_sm.core._model.events import FaultReport, SensorFrame

# --- the table --------------------------------------------------------------------------------


Row: TypeAlias = tuple[int, int, int, int, int]
TableRows: TypeAlias = tuple[Row, ...]


class BoardRows(NamedTuple):
    """The rows of a board's frame.

    ``whole`` is all of them: what it measures, the limits of that, two comparisons of motions with
    what was asked, and what follows.
    """

    whole: TableRows
    measured: TableRows
    stuck: TableRows
    rest: TableRows
    derived: TableRows


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
    return _TableCompiler(robot).table()


@lru_cache(maxsize=16)
def slots_read(robot: RobotSpec) -> tuple[int, ...]:
    """Return the slots whose setpoints the table reads; the others change no signal."""
    read = {wheel.slot for wheel in robot.wheels}
    for board in robot.boards.values():
        read |= {each.slot for each in board.derived}
        read |= {board.watched.sensors[place].slot for place in board.watched.moving}
    return tuple(sorted(read - {-1}))


class _TableCompiler:
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
            setpoint = () if each.slot < 0 else (layout.force + each.slot,)
            rest = map(constant, (*each.constants, 0.0, 0.0))
            a, b, c = (*each.sources, *setpoint, *rest)[:3]
            yield getattr(op, each.how.upper()), each.target, a, b, c
        places = [wheel.place for wheel in robot.wheels]
        for wheel in board.wheels:
            at = 2 + places.index(wheel.place) * op.WHEEL
            yield op.ODOMETRY, robot.odometry, at, 0, 0
        if board.wheels and robot.speed >= 0:
            yield op.SPEED, robot.speed, 0, 0, 0
        yield op.LOSS, layout.loss, constant(robot.link.period_s), 0, 0
        yield op.HEARD, layout.heard + board.position, 0, 0, 0


# --- frames -----------------------------------------------------------------------------------


def observe(
    robot: RobotSpec,
    sensing: Sensing,
    frame: SensorFrame,
    setpoints: Numbers,
    latest: Numbers,
    now: float,
    *,
    sent: bool = True,
) -> tuple[Sensing, list[FaultReport]]:
    """Return the signals after a frame, and reports of sensors found to be faulty.

    Rates are differences over the time since the board's last frame, at least over its period:
    delayed frames arrive together, which must not look like a faster motion.

    Args:
        robot: The robot with its boards.
        sensing: The signals before the frame.
        frame: Raw values; a frame of an unknown board is ignored.
        setpoints: Values in force per slot; they give the signs of the torques (eq. 5-3).
        latest: Values last sent, which may be in force already; a wheel driven by either is driven.
        now: When the frame was received.
        sent: Whether any array was ever sent.
    """
    board = robot.boards.get(frame.board)
    if board is None or len(frame.values) < board.length:
        return sensing, []
    table = signal_table(robot)
    rows = table.boards[board.position].whole  # most frames need nothing else
    asked = ask(robot, sensing.asked, latest if sent else (), now)
    elapsed_s = max(now - sensing.heard_s[board.position], robot.link.period_s)
    record, reports = sensing.records[board.position], list[FaultReport]()
    cells, raw = table.cells(sensing, setpoints, latest, asked), frame.values
    if record.special or not run(rows, table.lists, cells, sensing.numbers, raw, now, elapsed_s):
        cells = table.cells(sensing, setpoints, latest, asked)
        sensing, reports = _judged(robot, board, sensing, frame, cells, now, elapsed_s)
    elif record.seen <= robot.plausibility.hold_back:
        read = sensing.records_after([board.position], robot.plausibility)
        sensing = sensing._replace(records=read)
    stale = sensing.stale - {board.position} if sensing.stale else sensing.stale
    layout = table.layout
    numbers, heard_s = tuple(cells[: layout.heard]), tuple(cells[layout.heard : layout.shares])
    shares, angles = cells[layout.shares : layout.angles], cells[layout.angles : layout.motion]
    values = numbers, heard_s, sensing.checked_s, stale, tuple(shares), tuple(angles)
    # Faster than replacing fields by name; this runs for every frame. The others stay.
    loss, motion = cells[layout.loss], tuple(cells[layout.motion : layout.loss])
    return Sensing(*values, sensing.records, asked, loss, motion, *sensing[10:]), reports


def _judged(
    robot: RobotSpec,
    board: BoardSpec,
    sensing: Sensing,
    frame: SensorFrame,
    cells: list[float],
    now: float,
    elapsed_s: float,
) -> tuple[Sensing, list[FaultReport]]:
    """Return the signals before a frame that is not plain, and the faults that it shows.

    The cells, which are those before it, become those after it. The signals are without those from
    which no change is counted any more.
    """
    table = signal_table(robot)
    rows, lists = table.boards[board.position], table.lists

    def kept(some: Rows) -> bool:
        return run(some, lists, cells, sensing.numbers, frame.values, now, elapsed_s)

    kept(rows.measured)
    reading, motion = (
        Reading(sensing.numbers, elapsed_s, now),
        MotionRows(rows.stuck, rows.rest, kept),
    )
    record, reports = plausibility.sift(
        *(robot.plausibility, board.watched, sensing.records[board.position], cells, reading),
        motion,
    )
    if record is not sensing.records[board.position]:
        at, records = board.position, sensing.records
        sensing = _count_from_here(board, sensing, record, now)
        sensing = sensing._replace(records=(*records[:at], record, *records[at + 1 :]))
        cells[table.layout.angles : table.layout.motion] = sensing.angles
    kept(rows.derived)
    return sensing, reports


def _count_from_here(
    board: BoardSpec, sensing: Sensing, record: BoardMemory, now_s: float
) -> Sensing:
    """Return the signals before a frame, without those from which no change is counted any more.

    A counter that is believed to have restarted has not turned by the difference, nor that fast.
    """
    watched = zip(board.watched.sensors, record.channels, strict=True)
    restarted = {watch.number for watch, channel in watched if channel.since_s == now_s}
    if not restarted:
        return sensing
    places = {wheel.place for wheel in board.wheels if wheel.angle in restarted}
    distance = sensing.distance
    return sensing._replace(
        numbers=_without(restarted, sensing.numbers),
        angles=_without(places, sensing.angles),
        distance=distance._replace(angles=_without(places, distance.angles)),
    )


def _without(places: Collection[int], numbers: Numbers) -> tuple[float, ...]:
    return tuple(nan if at in places else each for at, each in enumerate(numbers))


def ask(robot: RobotSpec, asked: MotorRequest, setpoints: Numbers, now: float) -> MotorRequest:
    """Return what the motors have been asked when a frame comes, by which its motions are judged.

    Args:
        robot: The robot.
        asked: What they had been asked before.
        setpoints: The array last sent; empty before the first.
        now: When the frame was received.
    """
    if setpoints is asked.setpoints:
        return asked
    if setpoints == asked.setpoints:
        return asked._replace(setpoints=setpoints)  # identical objects compare faster next time
    driving = any(setpoints[wheel.slot] for wheel in robot.wheels) if setpoints else False
    return MotorRequest(setpoints, now, driving)


def forget_outdated(sensing: Sensing, now_s: float) -> Sensing:
    """Return the signals, with numbers from outside whose time has passed unknown."""
    outdated = [index for index, until_s in sensing.outside_until_s if until_s < now_s]
    if not outdated:
        return sensing
    numbers = list(sensing.numbers)
    for index in outdated:
        numbers[index] = nan
    kept = tuple(each for each in sensing.outside_until_s if each[0] not in outdated)
    return sensing._replace(numbers=tuple(numbers), outside_until_s=kept)


def forget_stale(robot: RobotSpec, sensing: Sensing, now: float) -> Sensing:
    """Return the signals, with those of boards that have not reported for too long unknown."""
    limit = now - robot.link.stale_after_s
    if min(sensing.heard_s, default=now) > limit:
        return sensing._replace(checked_s=now)
    table = signal_table(robot)
    numbers, records = table.cells(sensing), list(sensing.records)
    stale = set(sensing.stale)
    for board in robot.boards.values():
        if sensing.heard_s[board.position] <= limit and board.position not in stale:
            stale.add(board.position)
            for index in board.numbers:
                numbers[index] = nan
            # The first reading after the silence may be damaged: it is judged by the last one.
            at, spec = board.position, robot.plausibility
            rows, elapsed_s = table.boards[at], now - sensing.heard_s[at]
            reading, motion = Reading(sensing.numbers, elapsed_s, now), MotionRows(rows.stuck)
            records[at], _ = plausibility.sift(
                spec, board.watched, records[at], numbers, reading, motion
            )
    if robot.traction is not None:
        wheels = robot.traction.wheels
        lost = wheels if wheels[-1].board in stale else [w for w in wheels if w.board in stale]
        for index in (index for wheel in lost for index in wheel.targets):
            numbers[index] = nan
    if robot.speed >= 0 and all(isnan(numbers[wheel.speed]) for wheel in robot.wheels):
        numbers[robot.speed] = nan
    return sensing._replace(
        numbers=tuple(numbers[: table.layout.heard]),
        checked_s=now,
        stale=frozenset(stale),
        records=tuple(records),
    )
