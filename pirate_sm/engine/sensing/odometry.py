"""Compute odometry and speed from the driven wheels."""

from __future__ import annotations

from collections.abc import Collection
from math import isnan, nan

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.board_spec import BoardSpec
from pirate_sm.engine.sensing.known_signals import Numbers, Sensing
from pirate_sm.engine.sensing.sensor_memory import BoardMemory


def either(setpoints: Numbers, latest: Numbers) -> Numbers:
    """Return the setpoints in force, replaced by the latest where they are zero."""
    return tuple(old or new for old, new in zip(setpoints, latest, strict=True))


def roll_on(
    robot: RobotSpec,
    board: BoardSpec,
    sensing: Sensing,
    numbers: list[float],
    driven: Numbers,
    now: float,
) -> tuple[Numbers, Numbers]:
    """Update odometry and speed with a board's wheels; return the new shares and angles.

    Odometry is the mean distance rolled by the driven, measured wheels. A wheel's share is added
    when its board reports, for the whole time since its last report. A wheel whose board has been
    silent long enough for a fault gets no share from then on; the other wheels replace it. Nor does
    one that is not believed, see :mod:`.wheel_belief`.
    """
    limit_s = now - robot.link.silent_after_s
    silence_s = now - sensing.heard_s[board.position]
    own = min(1.0, robot.link.silent_after_s / silence_s) if silence_s > 0 else 1.0
    angles, shares = list(sensing.angles), list(sensing.shares)
    out = sensing.distance.out
    for wheel in board.wheels:
        angles[wheel.place] = numbers[wheel.angle]
    sharing = 0
    if any(driven[wheel.slot] for wheel in board.wheels):
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            if driven[wheel.slot] and not isnan(angles[wheel.place]) and wheel.place not in out:
                sharing += position == board.position or sensing.heard_s[position] > limit_s
    for wheel in board.wheels:
        counts = sharing and driven[wheel.slot] and wheel.place not in out
        share = 1 / sharing if counts else 0.0
        old, shares[wheel.place] = 0.0 if wheel.place in out else shares[wheel.place], share
        turned = angles[wheel.place] - sensing.angles[wheel.place]
        if robot.odometry >= 0 and not isnan(turned):
            numbers[robot.odometry] += turned * wheel.metres_per_rad * (old or share) * own
    if robot.speed >= 0:
        numbers[robot.speed] = _speed(robot, numbers, driven)
    return tuple(shares), tuple(angles)


def count_from_here(
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


def _speed(robot: RobotSpec, numbers: list[float], driven: Numbers) -> float:
    """Return the mean speed of the measured driven wheels, or of all wheels if none is driven."""
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
