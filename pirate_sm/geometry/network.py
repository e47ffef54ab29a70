"""Pipes as networks: runs of segments between junctions and ends.

A segment is a straight or a fitting. Fittings of other kinds (elbow, reducer, tee) are further
members of ``Segment``; a route is laid through any of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, pi, sin, tan
from typing import Literal, TypeAlias

from pirate_sm.geometry.space import Vector


@dataclass(frozen=True)
class Straight:
    """A piece of straight pipe.

    Attributes:
        length_m: Its length along the axis, up to where the axes cross.
    """

    length_m: float


@dataclass(frozen=True)
class Mitre:
    """A sharp bend of two pipes that are cut at half the angle.

    Attributes:
        angle_rad: How far the axis turns; positive towards side A of a robot with roll 0.
        roll_rad: How far the plane of the bend is rolled about the direction of travel, from side
            A to the normal, against the frame that is carried along without twist.
    """

    angle_rad: float
    roll_rad: float = 0.0

    def taken_m(self, diameter_m: float) -> float:
        """Return what the cut takes of the inner wall of each straight beside it."""
        return diameter_m / 2 * tan(abs(self.angle_rad) / 2)


Segment: TypeAlias = Straight | Mitre
Section: TypeAlias = Literal["bars", "round"]


@dataclass(frozen=True)
class Run:
    """A pipe without branches between two junctions or ends.

    Attributes:
        diameter_m: Inner diameter.
        segments: In order.
        begins: Name of the junction or end at which it begins.
        ends: Name of the junction or end to which it leads.
        section: What its walls are: two bars in a plane, or a round wall.
    """

    diameter_m: float
    segments: tuple[Segment, ...]
    begins: str = "entry"
    ends: str = "exit"
    section: Section = "bars"

    @property
    def taken_m(self) -> tuple[float, ...]:
        """What each segment takes of the inner wall of the straights beside it."""
        return tuple(
            each.taken_m(self.diameter_m) if isinstance(each, Mitre) else 0.0
            for each in self.segments
        )


@dataclass(frozen=True)
class Network:
    """Runs, and the routes through them.

    Attributes:
        runs: By name.
        routes: Names of the runs of each route, in order; each begins where the one before ends.
        up: The unit vector against gravity, in the frame of the first run of a route.
    """

    runs: Mapping[str, Run]
    routes: Mapping[str, tuple[str, ...]]
    up: Vector = field(default=(0.0, 0.0, -1.0))


def planar(
    diameter_m: float,
    segments: tuple[Segment, ...],
    tilt_rad: float = 0.0,
    uphill_rad: float = pi / 2,
    section: Section = "bars",
) -> Network:
    """Return the network of one run in a plane.

    Args:
        diameter_m: Inner diameter.
        segments: Of the run.
        tilt_rad: Angle between the plane and the horizontal: gravity in the plane is g sin(tilt).
        uphill_rad: Direction in the plane that goes up when tilted, from the first straight
            towards side A: 0 = the first straight goes up, 90 deg = the far leg of a mitre of
            90 deg goes up.
        section: Of the run.
    """
    run = Run(diameter_m, segments, section=section)
    return Network({"main": run}, {"main": ("main",)}, tilted_up(tilt_rad, uphill_rad))


def tilted_up(tilt_rad: float, uphill_rad: float) -> Vector:
    """Return the unit vector against gravity of a planar pipe; see :func:`planar`."""
    slope = sin(tilt_rad)
    return slope * cos(uphill_rad), slope * sin(uphill_rad), -cos(tilt_rad)
