"""Convert raw frames to signals: scales, rates, torques, diameters, odometry (appendix B)."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, isfinite, isnan, nan, sqrt

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing import plausibility
from pirate_sm.engine.sensing.board_spec import BoardSpec, Vector
from pirate_sm.engine.sensing.known_signals import MotorRequest, Numbers, Sensing
from pirate_sm.engine.sensing.odometry import count_from_here, either, roll_on
from pirate_sm.engine.sensing.report_loss import loss_after
from pirate_sm.engine.sensing.sensor_memory import Reading
from pirate_sm.geometry.clamping import height_m
from pirate_sm.model.events import FaultReport, SensorFrame


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
    numbers = convert(board, frame.values, sensing.numbers)
    elapsed_s = max(now - sensing.heard_s[board.position], robot.link.period_s)
    asked = ask(robot, sensing.asked, latest if sent else (), now)
    settled = not asked.driving and now - asked.since_s >= robot.plausibility.settle_s
    reading = Reading(sensing.numbers, elapsed_s, now, asked.setpoints, asked.since_s, settled)
    record, reports = plausibility.sift(
        robot.plausibility, board.watched, sensing.records[board.position], numbers, reading
    )
    records = sensing.records
    if record is not records[board.position]:
        sensing = count_from_here(board, sensing, record, now)
        records = (*records[: board.position], record, *records[board.position + 1 :])
    _derive(board, numbers, sensing.numbers, setpoints, elapsed_s)
    shares, angles = sensing.shares, sensing.angles
    if board.wheels:
        driven = setpoints if latest is setpoints else either(setpoints, latest)
        shares, angles = roll_on(robot, board, sensing, numbers, driven, now)
    heard = list(sensing.heard_s)
    heard[board.position] = now
    stale = sensing.stale - {board.position} if sensing.stale else sensing.stale
    loss = loss_after(sensing.loss, elapsed_s, robot.link.period_s)
    values = tuple(numbers), tuple(heard), sensing.checked_s, stale
    # Faster than replacing fields by name; this runs for every frame. The others stay.
    return Sensing(*(*values, shares, angles, records, asked, loss), *sensing[9:]), reports


def _derive(
    board: BoardSpec,
    numbers: list[float],
    before: Numbers,
    setpoints: Numbers,
    elapsed_s: float,
) -> None:
    """Compute the rates, torques, vectors and diameters derived from a board's values, in place."""
    for source, target in board.rates:
        numbers[target] = (numbers[source] - before[source]) / elapsed_s
    for source, slot, scale, target in board.torques:
        setpoint = setpoints[slot]
        sign = setpoint / abs(setpoint) if setpoint else 0.0  # NaN stays NaN
        numbers[target] = numbers[source] * scale * sign
    for vector in board.vectors:
        numbers[vector.target] = _vector(vector, numbers)
    for apex, length_m, wheels_m, target in board.diameters:
        angle = numbers[apex] if isfinite(numbers[apex]) else nan
        numbers[target] = height_m(length_m, angle) + wheels_m


def convert(board: BoardSpec, raw: Numbers, numbers: Sequence[float]) -> list[float]:
    """Return all numbers, with those that the board measures updated; SI units."""
    converted = list(numbers)
    for place, target, scale in board.channels:
        converted[target] = raw[place] * scale
    for target, zero in board.zeros:
        converted[target] -= zero
    return converted


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


def _vector(vector: Vector, numbers: list[float]) -> float:
    x, y, z = (numbers[source] for source in vector.sources)
    if vector.how == "norm":
        return sqrt(x * x + y * y + z * z)
    if isnan(x) or isnan(y) or isnan(z):
        return nan
    # B-13 and B-14; atan2 gives the same for an upright sensor and is valid in all quadrants.
    return atan2(-y, z) if vector.how == "roll" else atan2(x, sqrt(y * y + z * z))


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
    numbers, records = list(sensing.numbers), list(sensing.records)
    stale = set(sensing.stale)
    for board in robot.boards.values():
        if sensing.heard_s[board.position] <= limit and board.position not in stale:
            stale.add(board.position)
            for index in board.numbers:
                numbers[index] = nan
            # The first reading after the silence may be damaged: it is judged by the last one.
            at, spec = board.position, robot.plausibility
            reading = Reading(sensing.numbers, now - sensing.heard_s[at], now)
            records[at], _ = plausibility.sift(spec, board.watched, records[at], numbers, reading)
    if robot.traction is not None:
        wheels = robot.traction.wheels
        lost = wheels if wheels[-1].board in stale else [w for w in wheels if w.board in stale]
        for index in (index for wheel in lost for index in wheel.targets):
            numbers[index] = nan
    if robot.speed >= 0 and all(isnan(numbers[wheel.speed]) for wheel in robot.wheels):
        numbers[robot.speed] = nan
    return sensing._replace(
        numbers=tuple(numbers), checked_s=now, stale=frozenset(stale), records=tuple(records)
    )
