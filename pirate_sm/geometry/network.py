"""Pipes as networks: runs of segments between junctions and ends.

A segment is a straight or a fitting. Other fittings (elbow, reducer, tee) can be added as members
of ``Segment``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, pi, sin, tan
from typing import TypeAlias

from pirate_sm.geometry.space import Vector


@dataclass(frozen=True)
class Straight:
    """A piece of straight pipe.

    Attributes:
        length_m: Its length along the axis, up to the intersection with the next axis.
    """

    length_m: float


@dataclass(frozen=True)
class Mitre:
    """A sharp bend of two pipes that are cut at half the angle.

    Attributes:
        angle_rad: Angle of the bend; positive towards side A of a robot with roll 0.
        roll_rad: Roll of the bend's plane about the direction of travel, from side A to the
            normal, relative to the frame that is transported without twist.
    """

    angle_rad: float
    roll_rad: float = 0.0

    def taken_m(self, diameter_m: float) -> float:
        """Return by how much the cut shortens the inner wall of each adjacent straight, m."""
        return diameter_m / 2 * tan(abs(self.angle_rad) / 2)


Segment: TypeAlias = Straight | Mitre


@dataclass(frozen=True)
class Run:
    """A pipe without branches between two junctions or ends.

    Attributes:
        diameter_m: Inner diameter.
        segments: The segments in order.
        begins: Name of the junction or end where it begins.
        ends: Name of the junction or end where it ends.
    """

    diameter_m: float
    segments: tuple[Segment, ...]
    begins: str = "entry"
    ends: str = "exit"

    @property
    def taken_m(self) -> tuple[float, ...]:
        """Return by how much each segment shortens the inner wall of adjacent straights, m."""
        return tuple(
            each.taken_m(self.diameter_m) if isinstance(each, Mitre) else 0.0
            for each in self.segments
        )


@dataclass(frozen=True)
class Network:
    """Runs, and the routes through them.

    Attributes:
        runs: The runs by name.
        routes: By name the runs of each route in order; each begins where its predecessor ends.
        up: The unit vector opposite to gravity, in the frame of a route's first run.
    """

    runs: Mapping[str, Run]
    routes: Mapping[str, tuple[str, ...]]
    up: Vector = field(default=(0.0, 0.0, -1.0))


def planar(
    diameter_m: float,
    segments: tuple[Segment, ...],
    tilt_rad: float = 0.0,
    uphill_rad: float = pi / 2,
) -> Network:
    """Return the network of one run in a plane.

    Args:
        diameter_m: Inner diameter.
        segments: The segments of the run.
        tilt_rad: Angle between the plane and the horizontal: gravity in the plane is g sin(tilt).
        uphill_rad: Uphill direction in the tilted plane, from the first straight towards side A.
            0: the first straight goes up. 90 deg: the leg behind a mitre of 90 deg goes up.
    """
    slope = sin(tilt_rad)
    up = (slope * cos(uphill_rad), slope * sin(uphill_rad), -cos(tilt_rad))
    return Network({"main": Run(diameter_m, segments)}, {"main": ("main",)}, up)
