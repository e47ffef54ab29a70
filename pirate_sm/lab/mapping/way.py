"""The way that the parts of a robot have travelled, by the held part whose wheels slip least.

A driven wheel that slips turns farther than the robot moves. Parts along one leg move alike, but
for what the joints between them stretch, as at a reducer. So of two held parts that do not agree
the one counts that has rolled less; within a part the median of its wheels counts. In a bend the
wheels on its outer side roll farther than the pipe's axis is long, and those on its inner side
less: there the mean of the two sides counts.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pirate_sm.core.robot import RobotSpec
from pirate_sm.lab.mapping.looks import RobotLook
from pirate_sm.robot.detectors.odometer import Odometer

_PIECE_S = 5.0
"""Parts are compared over this time, or until they disagree [decided]."""

_AGREEING_M = 0.005
"""Parts that have rolled alike up to this have not slipped, and their mean counts: always to take
the lesser would add up noise [decided]."""


class Way:
    """Counts the way of each part, from zero.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        body = robot.body
        parts = range(len(body.parts))
        wheels = [body.wheels_of(part) for part in parts]
        self._straight = [_Rolled(robot, [own]) for own in wheels]
        self._bent = [
            _Rolled(robot, [[w for w in own if body.sides[w] == side] for side in (1, -1)])
            for own in wheels
        ]
        self._own_m = [0.0 for _ in parts]
        self._begun_m = [0.0 for _ in parts]
        self._counted_m = [0.0 for _ in parts]
        self._held: frozenset[int] = frozenset()
        self._places_m: dict[int, float] = {}
        self._begun_s = 0.0

    def until(
        self,
        look: RobotLook,
        held: Collection[int],
        places_m: Mapping[int, float],
        bent: Collection[int] = (),
    ) -> list[float]:
        """Return the way of each part until this look, m; backward counts negative.

        Args:
            look: What is known of the robot.
            held: The parts that hold it; empty if it lies loose.
            places_m: Where parts along one leg are against each other, by the joints.
            bent: The parts that stand in a bend.
        """
        for part, (straight, sides) in enumerate(zip(self._straight, self._bent, strict=True)):
            along_m, around_m = straight.since_last(look), sides.since_last(look)
            self._own_m[part] += around_m if part in bent else along_m
        counted_m, agreed = self._until_now(places_m)
        now = frozenset(held)
        anew = now != self._held or places_m.keys() != self._places_m.keys() or not agreed
        if anew or look.at_s - self._begun_s >= _PIECE_S:
            self._begun_m, self._begun_s, self._held = list(self._own_m), look.at_s, now
            self._counted_m, self._places_m = counted_m, dict(places_m)
        return counted_m

    def _until_now(self, places_m: Mapping[int, float]) -> tuple[list[float], bool]:
        """Return the way of each part, with this piece, and whether the parts agree on it."""
        parts = range(len(self._own_m))
        stretched_m = [0.0 for _ in parts]
        if places_m.keys() == self._places_m.keys():
            for part, place_m in places_m.items():
                stretched_m[part] = place_m - self._places_m[part]
        moved_m = [
            self._own_m[part] - self._begun_m[part] - stretched_m[part]
            for part in self._held or parts
        ]
        agreed = max(moved_m) - min(moved_m) <= _AGREEING_M
        alike_m = sum(moved_m) / len(moved_m) if agreed else min(moved_m, key=abs)
        return [self._counted_m[part] + alike_m + stretched_m[part] for part in parts], agreed


class _Rolled:
    """What groups of wheels have rolled: the mean of the groups."""

    def __init__(self, robot: RobotSpec, groups: Collection[Collection[int]]) -> None:
        self._groups = [(Odometer(robot), tuple(group)) for group in groups if group]
        self._last_m = 0.0

    def since_last(self, look: RobotLook) -> float:
        """Return what they have rolled since it was asked last, m."""
        counts = [look.travelled(odometer, wheels) for odometer, wheels in self._groups]
        before_m, self._last_m = self._last_m, sum(counts) / len(counts)
        return self._last_m - before_m
