"""Checks by the joint sensors whether a robot is straight, as it is declared."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import degrees, radians
from typing import NamedTuple

from pirate_sm.robot.diagnosis.facts import ExpectedRobot
from pirate_sm.robot.diagnosis.records import Records, meanings

STILL_RAD = radians(1)
"""A joint at rest flickers by less than this; a count is a tenth of it."""

LEAST_READINGS = 10


class JointReading(NamedTuple):
    """One joint's readings, without a zero subtracted.

    Attributes:
        mean: Mean, rad; likewise ``spread``, the difference of the extremes, and ``last``.
        taken: Number of readings.
    """

    name: str
    mean: float
    spread: float
    taken: int
    last: float


def read_joints(
    subject: ExpectedRobot, records: Records, joints: Sequence[str]
) -> list[JointReading]:
    """Return the readings of these joints since counting began."""
    found: list[JointReading] = []
    for number, record in records.boards.items():
        scales = {place: scale for place, (scale, _, _) in meanings(subject, number).items()}
        for place, channel in enumerate(record.board.channels):
            if channel.signal is not None and channel.signal in joints and place in scales:
                counted, scale = record.channels[place], abs(scales[place])
                spread = (counted.most - counted.least) * scale if counted.count else 0.0
                mean = counted.mean * scales[place]
                last = counted.last * scales[place]
                found.append(JointReading(channel.signal, mean, spread, counted.count, last))
    return sorted(found, key=lambda reading: list(joints).index(reading.name))


def objections(readings: Iterable[JointReading], limit_rad: float) -> list[str]:
    """Return why these readings must not become zeros, one sentence each; empty if they may."""
    found: list[str] = []
    for name, mean, spread, taken, _ in readings:
        if taken < LEAST_READINGS:
            found.append(
                f"{name} was read {taken} times only, not {LEAST_READINGS}: measure for longer, or "
                "its board is silent"
            )
        elif spread > STILL_RAD:
            found.append(
                f"{name} is not still: it moved by {degrees(spread):.1f} deg, "
                f"at most {degrees(STILL_RAD):g} deg is allowed"
            )
        elif abs(mean) > limit_rad:
            found.append(
                f"{name} shows {degrees(mean):+.1f} deg, more than {degrees(limit_rad):g} deg from "
                "zero: it is not straight, or its magnet has slipped and must be turned back"
            )
        elif spread == 0.0:
            found.append(f"{name} shows exactly the same all the time: is its sensor connected?")
    return found
