"""Pipes as networks: runs of segments between junctions and ends, and pieces of their centre lines.

A segment is a straight or a fitting. A fitting turns or narrows one run; a tee is a junction, where
runs meet. Rolls are about the direction of travel, in the frame that is carried along without
twist: 0 is towards side A of a robot with roll 0, a quarter turn is up where the run is flat and
that robot's axles stand upright. A robot's own roll has the same sense.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import atan2, cos, dist, inf, pi, remainder, sin, tan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._geometry.space import Frame, Vector, between, combined, dot


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

    @cached_property
    def diameters_m(self) -> tuple[float, ...]:
        """Return the inner diameter in front of each segment, and behind the last, m."""
        found = [self.diameter_m]
        for each in self.segments:
            found.append(each.to_m if isinstance(each, Reducer) else found[-1])
        return tuple(found)

    @cached_property
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


# --- pieces of the centre line ----------------------------------------------------------------


class Arc(NamedTuple):
    """The arc of a piece.

    Attributes:
        radius_m: Radius of the centre line.
        angle_rad: Angle by which it turns, positive.
        towards: Unit vector from the beginning towards the centre of the arc.
    """

    radius_m: float
    angle_rad: float
    towards: Vector

    def turned_round(self, ahead: Vector) -> Arc:
        """Return the arc for the other direction of travel, by the direction at its beginning."""
        c, s = cos(self.angle_rad), sin(self.angle_rad)
        return self._replace(towards=combined((c, self.towards), (-s, ahead)))


class Piece(NamedTuple):
    """A piece of the centre line from one fitting to the next, or the fitting itself.

    Attributes:
        frame: The frame at its beginning.
        length_m: Its length; of a straight between the intersections of the axes at its ends.
        arc_m: Arc length at its beginning.
        diameter_m: Inner diameter at its beginning.
        taken_m: By how much the fittings at its two ends shorten the inner wall.
        bend: The mitre at its end; None without one.
        run: Name of its run.
        segment: Index of its first segment in the run.
        section: What the walls of its run are.
        narrowed_m: Inner diameter at its end.
        arc: Its arc; None for a piece with a straight axis.
    """

    frame: Frame
    length_m: float
    arc_m: float
    diameter_m: float
    taken_m: tuple[float, float]
    bend: Mitre | None
    run: str
    segment: int
    section: Section = "bars"
    narrowed_m: float = inf
    arc: Arc | None = None

    @property
    def ends_m(self) -> float:
        """Return the arc length at its end, m."""
        return self.arc_m + self.length_m

    @property
    def ends_with_m(self) -> float:
        """Return the inner diameter at its end, m."""
        return self.diameter_m if self.narrowed_m == inf else self.narrowed_m

    @property
    def clear_m(self) -> tuple[float, float]:
        """Return the range of arc length in which it has walls all round, m."""
        return self.arc_m + self.taken_m[0], self.ends_m - self.taken_m[1]

    def diameter_at(self, arc_m: float) -> float:
        """Return the inner diameter at an arc length, m."""
        if self.narrowed_m in (inf, self.diameter_m):
            return self.diameter_m
        if self.length_m == 0.0:
            return self.narrowed_m
        share = min(max((arc_m - self.arc_m) / self.length_m, 0.0), 1.0)
        return self.diameter_m + share * (self.narrowed_m - self.diameter_m)

    def frame_at(self, arc_m: float) -> Frame:
        """Return the frame of the centre line at an arc length."""
        along, arc = arc_m - self.arc_m, self.arc
        if arc is None:
            return self.frame.moved(along)
        inside = min(max(along, 0.0), self.length_m)
        turned = self.frame.bent(arc.towards, inside / arc.radius_m)
        return turned._replace(origin=self._on_arc(arc, inside)).moved(along - inside)

    def point(self, arc_m: float, aside_m: float = 0.0) -> Vector:
        """Return the point at an arc length, ``aside_m`` from the centre line towards side A."""
        if self.arc is None:
            return self.frame.point(arc_m - self.arc_m, aside_m)
        return self.frame_at(arc_m).point(0.0, aside_m)

    def beyond_m(self, point: Vector) -> float:
        """Return the distance of a point from the beginning, along the centre line, m.

        It is negative before the beginning, and goes on along the tangent behind the end.
        """
        frame, arc = self.frame, self.arc
        (px, py, pz), (x, y, z), (ax, ay, az) = point, frame.origin, frame.ahead
        forward = (px - x) * ax + (py - y) * ay + (pz - z) * az
        if arc is None:
            return forward
        inward = dot(between(frame.origin, point), arc.towards)
        angle = atan2(forward, arc.radius_m - inward)
        if 0.0 <= angle <= arc.angle_rad:
            return angle * arc.radius_m
        if remainder(angle - arc.angle_rad / 2, 2 * pi) < 0.0:
            return min(forward, 0.0)
        end = self.frame_at(self.ends_m)
        return self.length_m + max(dot(between(end.origin, point), end.ahead), 0.0)

    def nearest(self, point: Vector, least_m: float, most_m: float) -> tuple[float, float]:
        """Return the distance of a point, and the nearest place within a range along it, m."""
        (px, py, pz), ((x, y, z), (ax, ay, az), *_) = point, self.frame
        along = (px - x) * ax + (py - y) * ay + (pz - z) * az
        if self.arc is not None:
            along = self.beyond_m(point)
        if along < least_m:  # faster than the least and the most; asked for each wheel in each look
            along = least_m
        elif along > most_m:
            along = most_m
        if self.arc is None:
            return dist(point, (x + along * ax, y + along * ay, z + along * az)), along
        if 0.0 <= along <= self.length_m:
            return dist(point, self._on_arc(self.arc, along)), along
        return dist(point, self.frame_at(self.arc_m + along).origin), along

    def _on_arc(self, arc: Arc, along_m: float) -> Vector:
        angle = along_m / arc.radius_m
        forward, inward = arc.radius_m * sin(angle), arc.radius_m * (1.0 - cos(angle))
        return combined(
            (1.0, self.frame.origin), (forward, self.frame.ahead), (inward, arc.towards)
        )

    def carried(self, before: Frame, after: Frame) -> Piece:
        """Return the piece moved as a body that takes the frame ``before`` to ``after``."""
        arc = self.arc
        if arc is not None:
            roll = self.frame.roll_of(arc.towards)
            moved = self.frame.carried(before, after)
            return self._replace(frame=moved, arc=arc._replace(towards=moved.towards(roll)))
        return self._replace(frame=self.frame.carried(before, after))

    def twisted(self, roll_rad: float) -> Piece:
        """Return the same piece with its frame rolled."""
        bend = self.bend and replace(self.bend, roll_rad=self.bend.roll_rad - roll_rad)
        return self._replace(frame=self.frame.rolled(roll_rad), bend=bend)

    def turned_round(self, bend: Mitre | None) -> Piece:
        """Return the piece for the other direction; ``bend`` is the mitre at its new end."""
        return self._replace(
            frame=self.frame_at(self.ends_m).reversed(),
            diameter_m=self.ends_with_m,
            narrowed_m=self.diameter_m,
            taken_m=(self.taken_m[1], self.taken_m[0]),
            bend=bend,
            arc=self.arc.turned_round(self.frame.ahead) if self.arc else None,
        )
