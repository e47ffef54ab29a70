"""Derive the range of each signal from end stops, motors, the wire format and geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, pi, sqrt
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.expressions.vocabulary import change_of
from pirate_sm.model import profile as model

_COUNTS = 2**15
"""The wire carries int16 values (PICO boards, thesis section 4-2)."""


class Range(NamedTuple):
    """The smallest and the largest value in SI units."""

    low: float = -inf
    high: float = inf


ANYTHING = Range()


def ranges(profile: model.Profile, robot: RobotSpec) -> Mapping[str, Range]:
    """Return the ranges of numeric signals; a signal without one is unlimited."""
    names = robot.vocabulary.numbers
    found: dict[str, Range] = {}
    for board in robot.boards.values():
        for _, target, scale in board.channels:
            found[names[target]] = Range(-_COUNTS * abs(scale), _COUNTS * abs(scale))
        for number, low, high in board.watched.ranges:  # what is beyond counts as unknown
            wire = found.get(names[number], ANYTHING)
            found[names[number]] = Range(max(low, wire.low), min(high, wire.high))
        for source, _, scale, target in board.torques:
            most = abs(scale) * found.get(names[source], ANYTHING).high
            found[names[target]] = Range(-most, most)
        for vector in board.vectors:
            most = sqrt(sum(found.get(names[s], ANYTHING).high ** 2 for s in vector.sources))
            found[names[vector.target]] = _VECTORS.get(vector.how, Range(0.0, most))
        for _, length_m, wheels_m, target in board.diameters:  # eq. 3-2
            found[names[target]] = Range(wheels_m, length_m + wheels_m)
    found |= dict(_of_body(profile, robot))
    changes = {change_of(n): Range(r.low - r.high, r.high - r.low) for n, r in found.items()}
    return found | changes


def _of_body(profile: model.Profile, robot: RobotSpec) -> Iterator[tuple[str, Range]]:
    """Yield the ranges of the angles of joints, and of the bound of the odometry."""
    names = robot.vocabulary.numbers
    for joint in profile.body.joints:
        if joint.name in names:
            yield joint.name, Range(-joint.end_stop, joint.end_stop)
    if robot.bound >= 0:
        yield names[robot.bound], Range(0.0)


_VECTORS = {"roll": Range(-pi, pi), "pitch": Range(-pi / 2, pi / 2)}
