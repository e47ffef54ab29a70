"""The way that a robot has travelled, by the held part whose wheels slip least.

A driven wheel that slips turns farther than the robot moves. All parts of a robot move alike, so of
two held parts the one counts that has rolled less; within a part the median of its wheels counts.
"""

from __future__ import annotations

from collections.abc import Collection

from pirate_sm.detectors.odometer import Odometer
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.mapping.looks import Look

_PIECE_S = 0.6
"""Parts are compared over this distance: two pieces of an odometer [decided]."""


class Way:
    """Counts the way, from zero.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        body = robot.body
        self._wheels = [body.wheels_of(part) for part in range(len(body.parts))]
        self._odometers = [Odometer(robot) for _ in self._wheels]
        self._held: frozenset[int] = frozenset()
        self._begun_m = [0.0] * len(self._wheels)
        self._begun_s = 0.0
        self._counted_m = 0.0

    def until(self, look: Look, held: Collection[int]) -> float:
        """Return the way until this look, m; backward counts negative.

        Args:
            look: What is known of the robot.
            held: The parts that hold it; empty if it lies loose.
        """
        counts = [
            look.travelled(odometer, wheels)
            for odometer, wheels in zip(self._odometers, self._wheels, strict=True)
        ]
        moved_m = self._moved(counts)
        now = frozenset(held)
        if now != self._held or look.at_s - self._begun_s >= _PIECE_S:
            self._counted_m += moved_m
            self._begun_m, self._begun_s, self._held = counts, look.at_s, now
            return self._counted_m
        return self._counted_m + moved_m

    def _moved(self, counts: list[float]) -> float:
        """Return the way since the present piece began, m."""
        parts = self._held or frozenset(range(len(counts)))
        return min((counts[part] - self._begun_m[part] for part in parts), key=abs, default=0.0)
