"""The true position of a simulated robot in its pipe, for views."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Truth:
    """The robot's true position in its pipe, for views and reports; no controller may use it.

    Attributes:
        wheels: Position of each wheel in the plane of the pipe, m.
        wheel_radius_m: Radius of the wheels.
        walls: Corners of each wall in the same plane, m: side A, then side B.
        distance_m: The robot's position along the pipe.
        touching: Whether each wheel presses on a wall; empty if unknown.
        rolls_rad: Angle of the roll joint, then the roll of the front and of the rear part
            relative to the plane of the pipe; empty if unknown.
    """

    wheels: tuple[tuple[float, float], ...]
    wheel_radius_m: float
    walls: tuple[tuple[tuple[float, float], ...], ...]
    distance_m: float
    touching: tuple[bool, ...] = ()
    rolls_rad: tuple[float, ...] = ()
