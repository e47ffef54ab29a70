"""The true position of a simulated robot in its pipe, for views."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Truth:
    """Where the robot is in its pipe: for a view and an end, not for use.

    Attributes:
        wheels: Place of each wheel in the plane of the pipe, m.
        wheel_radius_m: Of the wheels.
        walls: Corners of each wall in the same plane, m; side A, then side B.
        distance_m: How far the robot has come along the pipe.
        touching: Whether each wheel presses on a wall; empty where that is not known.
        rolls_rad: Angle of the roll joint, then roll of the part ahead and of the part behind
            against the plane of the pipe; empty where that is not known.
    """

    wheels: tuple[tuple[float, float], ...]
    wheel_radius_m: float
    walls: tuple[tuple[tuple[float, float], ...], ...]
    distance_m: float
    touching: tuple[bool, ...] = ()
    rolls_rad: tuple[float, ...] = ()
