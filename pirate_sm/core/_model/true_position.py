"""The true position of a simulated robot in its pipe, for views."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from typing import NamedTuple

from pirate_sm.core._geometry.space import Vector


class InSpace(NamedTuple):
    """What the places of a robot's wheels in a plane leave out of a robot in space.

    Attributes:
        z_m: Third coordinate of each wheel, across the plane of the drawing.
        rolls_rad: As in :class:`Truth`.
    """

    z_m: tuple[float, ...]
    rolls_rad: tuple[float, ...]


@dataclass(frozen=True)
class Truth:
    """The robot's true position in its pipe, for views and reports; no controller may use it.

    Attributes:
        wheels: Position of each wheel in the plane of the drawing, m.
        wheel_radius_m: Radius of the wheels.
        walls: Corners of each wall in the same plane, m: side A, then side B; empty for a pipe that
            does not lie in it.
        distance_m: The robot's position along the pipe.
        touching: Whether each wheel presses on a wall; empty if unknown.
        rolls_rad: Angle of the roll joint, then the roll of the front and of the rear part
            relative to the frame of the pipe where they are; empty if unknown.
        z_m: Third coordinate of each wheel, across that plane; empty if the robot moves in it.
        run: The run of the pipe in which the first wheel is; empty if unknown.
        arc_m: Position of the first wheel along the route; NaN if unknown.
    """

    wheels: tuple[tuple[float, float], ...]
    wheel_radius_m: float
    walls: tuple[tuple[tuple[float, float], ...], ...]
    distance_m: float
    touching: tuple[bool, ...] = ()
    rolls_rad: tuple[float, ...] = ()
    z_m: tuple[float, ...] = ()
    run: str = ""
    arc_m: float = nan

    @property
    def points(self) -> tuple[Vector, ...]:
        """Return the position of each wheel in space, in the frame of the drawing, m."""
        return tuple(
            (x, y, z)
            for (x, y), z in zip(self.wheels, self.z_m or (0.0,) * len(self.wheels), strict=True)
        )
