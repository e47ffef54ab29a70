"""Derive the range of each signal from end stops, motors, the wire format and geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf, pi, sqrt
from typing import NamedTuple

from pirate_sm.core import profile as model
from pirate_sm.core.expressions import change_of
from pirate_sm.core.robot import RobotSpec

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
        for each in board.derived:
            most = [found.get(names[source], ANYTHING).high for source in each.sources]
            match each.how:
                case "torque":
                    limit = abs(each.factor) * most[0]
                    found[names[each.target]] = Range(-limit, limit)
                case "norm":
                    found[names[each.target]] = Range(0.0, sqrt(sum(high**2 for high in most)))
                case "roll" | "pitch":
                    found[names[each.target]] = _VECTORS[each.how]
                case "diameter":  # eq. 3-2
                    found[names[each.target]] = Range(each.more, each.factor + each.more)
                case "rate":
                    pass
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
