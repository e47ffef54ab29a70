"""Make signals of raw frames: conversions, rates, torques, diameters, odometry (appendix B)."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, hypot, inf, isfinite, isnan, nan, sqrt
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import BoardSpec, RobotSpec, Vector
from pirate_sm.engine.sensing import plausibility
from pirate_sm.engine.sensing.report_loss import loss_after
from pirate_sm.engine.sensing.sensor_memory import Reading, Record
from pirate_sm.geometry.clamping import height_m
from pirate_sm.model.events import FaultReport, SensorFrame

Numbers = tuple[float, ...]


class MotorRequest(NamedTuple):
    """What the motors have been asked.

    Attributes:
        setpoints: The array last sent; empty before the first.
        since_s: When it was sent.
        driving: Whether a wheel is driven.
    """

    setpoints: Numbers = ()
    since_s: float = inf
    driving: bool = False


class Sensing(NamedTuple):
    """What is known of the world.

    Attributes:
        numbers: Signals in the order of the vocabulary, SI; NaN is unknown.
        heard_s: Per board when it last reported; -inf before it ever did.
        checked_s: When staleness was last looked at.
        stale: Boards whose signals have been forgotten.
        shares: Per wheel its share of the odometry when its board last reported; 0 when the wheel
            was not driven then. A wheel that has just been stopped still brings in what it
            rolled until then.
        angles: Per wheel what its sensor last showed, however long ago: what it has rolled while
            its board could not be heard is not lost with the frames.
        records: Per board what is remembered of its sensors, to know which values to believe.
        asked: What the motors have been asked, which tells what can move.
        loss: Share of the boards' reports that is lost, lately.
        told: In place of ``numbers``, what a script says that conditions see; empty without one.
            Changes of signals may follow, see :func:`with_changes`.
    """

    numbers: Numbers
    heard_s: tuple[float, ...]
    checked_s: float = 0.0
    stale: frozenset[int] = frozenset()
    shares: tuple[float, ...] = ()
    angles: tuple[float, ...] = ()
    records: tuple[Record, ...] = ()
    asked: MotorRequest = MotorRequest()
    loss: float = 0.0
    told: Numbers = ()

    @property
    def shown(self) -> Numbers:
        """Return what conditions of the mission see; position loops go by the boards alone."""
        return self.told[: len(self.numbers)] or self.numbers

    @property
    def doubted(self) -> frozenset[int]:
        """Return the number indexes that rest on a sensor whose last reading is not believed.

        The number is NaN, except in the first few readings, where it is the last believed value:
        the sensor may only have spiked.
        """
        return frozenset().union(*[record.doubted for record in self.records])


def with_changes(sensing: Sensing, origin: Numbers) -> Numbers:
    """Return the signals, and after them how much each has changed since a wait began.

    Args:
        sensing: What is known now.
        origin: The signals when the wait began. A change is unknown (NaN) where the signal is
            unknown now or was unknown then.
    """
    shown = sensing.shown
    if len(sensing.told) > len(shown):  # a script says the changes too
        return sensing.told
    return (*shown, *(now - then for now, then in zip(shown, origin, strict=True)))


def nothing_known(robot: RobotSpec, *, blind: bool = False) -> Sensing:
    """Return unknown signals; the odometer stands at zero unless nothing will ever be seen."""
    numbers = [nan] * len(robot.vocabulary.numbers)
    if robot.odometry >= 0 and not blind:
        numbers[robot.odometry] = 0.0
    count = len(robot.wheels)
    return Sensing(
        tuple(numbers),
        (-inf,) * len(robot.boards),
        shares=(0.0,) * count,
        angles=(nan,) * count,
        records=tuple(plausibility.unseen(board.watched) for board in robot.boards.values()),
    )


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
    """Return what is known after a frame, and the sensors that have been found to be wrong.

    Speeds are those over the time since the board's last frame, but at least over its period:
    frames that have waited together are read together, and a wheel has not turned faster for it.

    Args:
        robot: Whose boards they are.
        sensing: What was known before.
        frame: Raw values; a board that the robot does not have changes nothing.
        setpoints: Values in force per slot; they give the sign of currents (eq. 5-3).
        latest: Values last sent, which may be in force already: a wheel is driven by either.
        now: When the frame was received.
        sent: Whether anything has been sent at all.
    """
    board = robot.boards.get(frame.board)
    if board is None or len(frame.values) < board.length:
        return sensing, []
    before = sensing.numbers
    numbers = convert(board, frame.values, before)
    elapsed_s = max(now - sensing.heard_s[board.position], robot.link.period_s)
    asked = _ask(robot, sensing.asked, latest if sent else (), now)
    settled = not asked.driving and now - asked.since_s >= robot.plausibility.settle_s
    reading = Reading(before, elapsed_s, now, asked.setpoints, asked.since_s, settled)
    record, reports = plausibility.sift(
        robot.plausibility, board.watched, sensing.records[board.position], numbers, reading
    )
    for source, target in board.rates:
        numbers[target] = (numbers[source] - before[source]) / elapsed_s
    for source, slot, scale, target in board.torques:
        setpoint = setpoints[slot]
        sign = 0.0 if setpoint == 0 else (1.0 if setpoint > 0 else -1.0)
        numbers[target] = numbers[source] * scale * sign
    for vector in board.vectors:
        numbers[vector.target] = _vector(vector, numbers)
    for apex, length_m, wheels_m, target in board.diameters:
        angle = numbers[apex] if isfinite(numbers[apex]) else nan
        numbers[target] = height_m(length_m, angle) + wheels_m
    shares, angles = sensing.shares, sensing.angles
    if board.wheels:
        driven = setpoints if latest is setpoints else _either(setpoints, latest)
        shares, angles = _roll_on(robot, board, sensing, numbers, driven, now)
    heard, records = list(sensing.heard_s), sensing.records
    heard[board.position] = now
    if record is not records[board.position]:
        records = (*records[: board.position], record, *records[board.position + 1 :])
    stale = sensing.stale - {board.position} if sensing.stale else sensing.stale
    loss = loss_after(sensing.loss, elapsed_s, robot.link.period_s)
    sensed = Sensing(
        tuple(numbers), tuple(heard), sensing.checked_s, stale, shares, angles,
        records, asked, loss,
    )  # fmt: skip
    return sensed, reports


def convert(board: BoardSpec, raw: Numbers, numbers: Sequence[float]) -> list[float]:
    """Return the numbers with those that the board measures in place of what they were, in SI."""
    converted = list(numbers)
    for place, target, scale in board.channels:
        converted[target] = raw[place] * scale
    for target, zero in board.zeros:
        converted[target] -= zero
    return converted


def _ask(robot: RobotSpec, asked: MotorRequest, setpoints: Numbers, now: float) -> MotorRequest:
    """Return what the motors have been asked since when."""
    if setpoints is asked.setpoints:
        return asked
    if setpoints == asked.setpoints:
        return asked._replace(setpoints=setpoints)  # so that they are the same next time
    driving = any(setpoints[wheel.slot] for wheel in robot.wheels) if setpoints else False
    return MotorRequest(setpoints, now, driving)


def _vector(vector: Vector, numbers: list[float]) -> float:
    x, y, z = (numbers[source] for source in vector.sources)
    if vector.how == "norm":
        return sqrt(x * x + y * y + z * z)
    if isnan(x) or isnan(y) or isnan(z):
        return nan
    # B-13 and B-14; atan2 agrees where the sensor is upright and is right elsewhere too.
    return atan2(-y, z) if vector.how == "roll" else atan2(x, hypot(y, z))


def _either(setpoints: Numbers, latest: Numbers) -> Numbers:
    return tuple(old or new for old, new in zip(setpoints, latest, strict=True))


def _roll_on(
    robot: RobotSpec,
    board: BoardSpec,
    sensing: Sensing,
    numbers: list[float],
    driven: Numbers,
    now: float,
) -> tuple[Numbers, Numbers]:
    """Take a board's wheels into odometry and speed; return the new shares and angles.

    Odometry is the mean over the driven wheels that can be measured of what their rims rolled;
    each wheel's share is added when its board reports, for all the time since it last did. One
    whose board has been silent for so long that it is a fault has no share from then on: the
    others stand in, and of its own way only the part before that counts.
    """
    limit_s = now - robot.link.silent_after_s
    silence_s = now - sensing.heard_s[board.position]
    own = min(1.0, robot.link.silent_after_s / silence_s) if silence_s > 0 else 1.0
    angles, shares = list(sensing.angles), list(sensing.shares)
    for wheel in board.wheels:
        angles[wheel.place] = numbers[wheel.angle]
    sharing = 0
    if any(driven[wheel.slot] for wheel in board.wheels):
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            if driven[wheel.slot] and not isnan(angles[wheel.place]):
                sharing += position == board.position or sensing.heard_s[position] > limit_s
    for wheel in board.wheels:
        share = 1 / sharing if sharing and driven[wheel.slot] else 0.0
        old, shares[wheel.place] = shares[wheel.place], share
        turned = angles[wheel.place] - sensing.angles[wheel.place]
        if robot.odometry >= 0 and not isnan(turned):
            numbers[robot.odometry] += turned * wheel.metres_per_rad * (old or share) * own
    if robot.speed >= 0:
        numbers[robot.speed] = _speed(robot, numbers, driven)
    return tuple(shares), tuple(angles)


def _speed(robot: RobotSpec, numbers: list[float], driven: Numbers) -> float:
    """Return the mean over the driven wheels that can be measured, over all when none is driven."""
    known, total, every, sum_ = 0, 0.0, 0, 0.0
    for wheel in robot.wheels:
        speed = numbers[wheel.speed] * wheel.metres_per_rad
        if isnan(speed):
            continue
        every, sum_ = every + 1, sum_ + speed
        if driven[wheel.slot]:
            known, total = known + 1, total + speed
    if known:
        return total / known
    return sum_ / every if every else nan


def forget_stale(robot: RobotSpec, sensing: Sensing, now: float) -> Sensing:
    """Make the signals of boards unknown that have not reported for too long."""
    limit = now - robot.link.stale_after_s
    if min(sensing.heard_s, default=now) > limit:
        return sensing._replace(checked_s=now)
    numbers = list(sensing.numbers)
    stale = set(sensing.stale)
    for board in robot.boards.values():
        if sensing.heard_s[board.position] <= limit and board.position not in stale:
            stale.add(board.position)
            for index in board.numbers:
                numbers[index] = nan
    if robot.speed >= 0 and all(isnan(numbers[wheel.speed]) for wheel in robot.wheels):
        numbers[robot.speed] = nan
    return sensing._replace(numbers=tuple(numbers), checked_s=now, stale=frozenset(stale))
