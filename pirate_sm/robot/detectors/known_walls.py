"""Finds where a robot is by the walls of its pipe: no wheel can be in one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import isnan, nan

from pirate_sm.core.geometry import Room, Route, Vector

_IN_WALL_M = 0.005
"""A wheel that is deeper in a wall shows that the robot is elsewhere. At its true place it is less
than 4 mm in 9 of 10 looks [measured in 3-D]: diameters are uncertain, and a part leans."""

_CLEAR_M = 0.003
"""Where no wheel is deeper in a wall than this, the robot may be [decided]."""

_STEP_M = 0.003

_MOST_M = 0.25
"""Places farther away are never looked at: what happened on so long a way is unknown [decided]."""


class KnownWalls:
    """The walls of the pipes of a route.

    Args:
        route: The route.
        wheel_radius_m: Radius of the robot's wheels.
        reach_m: How far a wheel may be from any other one.
    """

    def __init__(self, route: Route, wheel_radius_m: float, reach_m: float) -> None:
        self._everywhere = Room.of(route, wheel_radius_m)
        self._reach_m = reach_m + _MOST_M

    def away_m(
        self, points: Sequence[Vector], laid: Callable[[float], Sequence[Vector]], most_m: float
    ) -> float:
        """Return how far away the nearest place is at which no wheel is in a wall.

        Args:
            points: The wheels of the robot, one of them at least known; NaN is unknown.
            laid: Returns them after the robot was moved ahead by a distance.
            most_m: Places farther away are not looked at.

        Returns:
            The distance, positive ahead; 0 if the robot may be where it is; NaN if there is no
            such place.
        """
        known = [point for point in points if not isnan(point[0])]
        if _have_room(self._everywhere, known, _IN_WALL_M):
            return 0.0
        near = self._everywhere.near(known[0], self._reach_m)
        for step in range(1, round(min(most_m, _MOST_M) / _STEP_M) + 1):
            for away_m in (step * _STEP_M, -step * _STEP_M):
                if _have_room(near, laid(away_m), _CLEAR_M):
                    return away_m
        return nan


def _have_room(room: Room, points: Sequence[Vector], most_m: float) -> bool:
    """Return whether no wheel is farther in a wall; an unknown one is in none."""
    return all(isnan(it[0]) or room.outside_m(it, most_m) <= most_m for it in points)
