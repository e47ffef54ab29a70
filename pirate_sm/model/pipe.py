"""Pipes: straights and mitre bends in one plane, with data for simulators."""

from __future__ import annotations

import math
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Field, Tag

from pirate_sm.geometry import network as space
from pirate_sm.geometry.route import Route
from pirate_sm.model.base import Format, Frozen, Name, by_key
from pirate_sm.model.quantities import Angle, Duration, Length, range_fault
from pirate_sm.model.simulation import Friction

_ROUNDING_DEG = 1e-6


def _within(limit_deg: int) -> AfterValidator:
    """Return a validator of angles up to a limit in either direction."""

    def check(angle_rad: float) -> float:
        angle_deg = math.degrees(angle_rad)
        if abs(angle_deg) <= limit_deg + _ROUNDING_DEG:
            return angle_rad
        bound = f"at most {limit_deg}" if angle_deg > 0 else f"at least -{limit_deg}"
        raise range_fault(f"expected {bound} deg, got {angle_deg:.6g} deg")

    return AfterValidator(check)


class Straight(Frozen):
    """A straight of this length, measured along the axis to the intersection of the axes.

    Attributes:
        straight: Its length, measured along the axis to the intersection of the axes.
    """

    straight: Annotated[Length, Field(gt=0, le=100)]


class Mitre(Frozen):
    """A mitre bend by this angle; positive turns to side A of the robot in normal polarity.

    Attributes:
        mitre: Its angle, at most 120 deg in either direction; positive turns to side A of the robot
            in normal polarity.
    """

    mitre: Annotated[Angle, _within(120)]


Segment: TypeAlias = Annotated[
    Annotated[Straight, Tag("straight")] | Annotated[Mitre, Tag("mitre")],
    by_key(
        ("straight", "mitre"),
        custom_error_type="segment",
        custom_error_message="expected a segment, {straight: 1.0 m} or {mitre: 90 deg}",
    ),
]


class Blockage(Frozen):
    """An obstacle ``at`` a position that disappears after being pushed for ``lasting``.

    Attributes:
        at: Position along the axis, from the beginning of the pipe.
        lasting: How long it withstands a push before it is removed.
        from_s: Mission time at which it appears.
    """

    at: Annotated[Length, Field(ge=0)]
    lasting: Annotated[Duration, Field(ge=0)]
    from_s: Annotated[Duration, Field(alias="from", ge=0)] = 0.0


class Start(Frozen):
    """The start of a simulated robot: the position of its first wheel along the axis.

    Attributes:
        at: Position of the robot's first wheel along the axis, from the beginning of the pipe.
    """

    at: Annotated[Length, Field(ge=0)]


class Pipe(Frozen):
    """A pipe in one plane.

    Attributes:
        format: Version of this format.
        pipe: Name of the pipe.
        description: One-line description.
        diameter: Inner diameter.
        tilt: Tilt of the pipe's plane against the horizontal; gravity has the component g sin(tilt)
            in the plane.
        uphill: Uphill direction in the tilted plane, measured from the axis of the first segment
            towards side A. 0 deg: the first segment goes up. 90 deg: a leg behind a mitre of
            +90 deg goes up.
        roll: Roll of the pipe's plane about the axis of its first segment, relative to the robot's
            plane.
        segments: Straights, joined by mitres.
        friction: Friction of the wall; overrides the robot's values.
        start: Start of a simulated robot; by default in the middle of the first segment.
        blockages: Obstacles.
    """

    format: Format = 1
    pipe: Name | None = None
    description: str = ""
    diameter: Annotated[Length, Field(gt=0, le=10)]
    tilt: Annotated[Angle, _within(90)] = 0.0
    uphill: Annotated[Angle, _within(360)] = 0.0
    roll: Annotated[Angle, _within(180)] = 0.0
    segments: Annotated[tuple[Segment, ...], Field(min_length=1, max_length=100)]
    friction: Friction | None = None
    start: Start | None = None
    blockages: tuple[Blockage, ...] = ()

    def network(self, diameter_m: float | None = None) -> space.Network:
        """Return the pipe as a network of one run, optionally with another diameter."""
        segments = tuple(
            space.Straight(each.straight) if isinstance(each, Straight) else space.Mitre(each.mitre)
            for each in self.segments
        )
        return space.planar(diameter_m or self.diameter, segments, self.tilt, self.uphill)

    def route(self) -> Route:
        """Return the route through the pipe."""
        return Route(self.network())

    def start_of(self, robot_length_m: float) -> float:
        """Return the start position of the first wheel along the axis, m."""
        if self.start is not None:
            return self.start.at
        first = self.segments[0]
        middle = 0.5 * first.straight if isinstance(first, Straight) else 0.0
        return middle + 0.5 * robot_length_m
