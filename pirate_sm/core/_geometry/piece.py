"""A piece of the centre line: straight, along an arc, or through a cone."""

from __future__ import annotations

from dataclasses import replace
from math import atan2, cos, dist, inf, pi, remainder, sin
from typing import NamedTuple

from pirate_sm.core._geometry.network import Mitre, Section
from pirate_sm.core._geometry.space import Frame, Vector, between, combined, dot


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
        if self.ends_with_m == self.diameter_m or self.length_m == 0.0:
            return self.ends_with_m
        share = min(max((arc_m - self.arc_m) / self.length_m, 0.0), 1.0)
        return self.diameter_m + share * (self.ends_with_m - self.diameter_m)

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
        along = min(max(self.beyond_m(point), least_m), most_m)
        if self.arc is None:
            return dist(point, self.frame.point(along)), along
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
