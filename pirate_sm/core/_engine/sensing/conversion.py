"""Take frames of boards in, and forget what is known no more."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import isnan, nan

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.sensing import plausibility
from pirate_sm.core._engine.sensing.board_spec import BoardSpec
from pirate_sm.core._engine.sensing.known_signals import MotorRequest, Sensing
from pirate_sm.core._engine.sensing.motion_plausibility import MotionRows, Rows
from pirate_sm.core._engine.sensing.sensor_memory import BoardMemory, Reading
from pirate_sm.core._engine.signals.evaluator import run
from pirate_sm.core._engine.signals.table import signal_table
from pirate_sm.core._model.events import FaultReport, SensorFrame


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
    calm = not record.special and record.seen > robot.plausibility.hold_back
    if not (calm and run(rows, table.lists, cells, sensing.numbers, raw, now, elapsed_s)):
        cells = table.cells(sensing, setpoints, latest, asked)
        sensing, reports = _judged(robot, board, sensing, frame, cells, now, elapsed_s)
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


def measured(robot: RobotSpec, frame: SensorFrame, cells: Sequence[float]) -> list[float]:
    """Return the cells, with the signals that a board of the robot measures; SI units."""
    table, measured = signal_table(robot), list(cells)
    rows = table.boards[robot.boards[frame.board].position].measured
    run(rows, table.lists, measured, cells, frame.values, 0.0, 0.0)
    return measured


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
