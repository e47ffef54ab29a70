"""Pipes as networks: runs of segments between junctions and ends.

A segment is a straight or a fitting. A fitting turns or narrows one run; a tee is a junction, where
runs meet. Rolls are about the direction of travel, in the frame that is carried along without
twist: 0 is towards side A of a robot with roll 0, a quarter turn is up where the run is flat and
that robot's axles stand upright. A robot's own roll has the same sense.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, pi, sin, tan
from typing import Literal, TypeAlias

from pirate_sm.core._geometry.space import Vector


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
        roll_rad: Roll of the bend's plane about the direction of travel.
    """

    angle_rad: float
    roll_rad: float = 0.0

    def taken_m(self, diameter_m: float) -> float:
        """Return by how much the cut shortens the inner wall of each adjacent straight, m."""
        return diameter_m / 2 * tan(abs(self.angle_rad) / 2)


@dataclass(frozen=True)
class Elbow:
    """A bend along an arc.

    Attributes:
        angle_rad: Angle of the bend; positive towards side A of a robot with roll 0.
        radius_m: Radius of its centre line.
        roll_rad: Roll of the bend's plane about the direction of travel.
    """

    angle_rad: float
    radius_m: float
    roll_rad: float = 0.0

    @property
    def length_m(self) -> float:
        """Return the length of its centre line, m."""
        return self.radius_m * abs(self.angle_rad)


@dataclass(frozen=True)
class Reducer:
    """A change of the diameter, about one axis.

    Attributes:
        length_m: Length of its cone; 0 is a step.
        to_m: Inner diameter behind it.
    """

    length_m: float
    to_m: float


@dataclass(frozen=True)
class Tee:
    """A junction where a branch leaves a straight run at a right angle.

    Runs meet at its ports. The port ``NAME`` is where the run comes that fixes its frame,
    ``NAME.on`` where it goes straight on, and ``NAME.branch`` where it branches off.

    Attributes:
        roll_rad: Direction of the branch about the direction from ``NAME`` to ``NAME.on``.
    """

    roll_rad: float = 0.0


Segment: TypeAlias = Straight | Mitre | Elbow | Reducer
Section: TypeAlias = Literal["bars", "round"]


@dataclass(frozen=True)
class NetworkRun:
    """A pipe without branches between two junctions or ends.

    Attributes:
        diameter_m: Inner diameter.
        segments: The segments in order.
        begins: Name of the junction or end where it begins.
        ends: Name of the junction or end where it ends.
        section: What its walls are: two bars in a plane, or a round wall.
    """

    diameter_m: float
    segments: tuple[Segment, ...]
    begins: str = "entry"
    ends: str = "exit"
    section: Section = "bars"

    @property
    def diameters_m(self) -> tuple[float, ...]:
        """Return the inner diameter in front of each segment, and behind the last, m."""
        found = [self.diameter_m]
        for each in self.segments:
            found.append(each.to_m if isinstance(each, Reducer) else found[-1])
        return tuple(found)

    @property
    def taken_m(self) -> tuple[float, ...]:
        """Return by how much each segment shortens the inner wall of adjacent straights, m."""
        return tuple(
            each.taken_m(diameter) if isinstance(each, Mitre) else 0.0
            for each, diameter in zip(self.segments, self.diameters_m, strict=False)
        )


IN, ON, BRANCH = "", "on", "branch"
"""The ports of a tee."""


def port_of(name: str) -> tuple[str, str]:
    """Return the junction and its port that the beginning or end of a run names."""
    junction, _, port = name.partition(".")
    return junction, port


@dataclass(frozen=True)
class Network:
    """Runs, and the routes through them.

    Attributes:
        runs: The runs by name.
        routes: By name the runs of each route in order; neighbours meet in a junction.
        up: The unit vector opposite to gravity, in the drawing: the frame of the first of the runs.
        tees: The tees by name.
        closed: The ends that are closed; all others are open.
    """

    runs: Mapping[str, NetworkRun]
    routes: Mapping[str, tuple[str, ...]]
    up: Vector = field(default=(0.0, 0.0, -1.0))
    tees: Mapping[str, Tee] = field(default_factory=dict)
    closed: frozenset[str] = frozenset()

    def meet_at(self, name: str) -> tuple[tuple[str, bool], ...]:
        """Return the runs at a junction or end, each with whether it begins there."""
        return tuple(
            (run, begins)
            for run, each in self.runs.items()
            for begins, at in ((True, each.begins), (False, each.ends))
            if port_of(at)[0] == name
        )


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
        segments: The segments of the run.
        tilt_rad: Angle between the plane and the horizontal: gravity in the plane is g sin(tilt).
        uphill_rad: Uphill direction in the tilted plane, from the first straight towards side A.
            0: the first straight goes up. 90 deg: the leg behind a mitre of 90 deg goes up.
        section: What the walls of the run are.
    """
    run = NetworkRun(diameter_m, segments, section=section)
    return Network({"main": run}, {"main": ("main",)}, tilted_up(tilt_rad, uphill_rad))


def tilted_up(tilt_rad: float, uphill_rad: float) -> Vector:
    """Return the unit vector against gravity of a planar pipe; see :func:`planar`."""
    slope = sin(tilt_rad)
    return slope * cos(uphill_rad), slope * sin(uphill_rad), -cos(tilt_rad)
