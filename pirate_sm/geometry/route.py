"""A route through a network: arc length ↔ point, frame and diameter."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import dist, inf
from typing import NamedTuple

from pirate_sm.geometry.network import Mitre, Network, Run, Section, Straight
from pirate_sm.geometry.space import DRAWING, Frame, Vector


class Piece(NamedTuple):
    """A straight piece of the centre line, from one fitting to the next.

    Attributes:
        frame: The frame at its beginning.
        length_m: Its length between the intersections of the axes at its ends.
        arc_m: Arc length of the route at its beginning.
        diameter_m: Inner diameter.
        taken_m: By how much the fittings at its two ends shorten the inner wall.
        bend: The mitre at its end; None at the end of a run.
        run: Name of its run.
        segment: Index of its first segment in the run.
        section: What the walls of its run are.
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

    @property
    def ends_m(self) -> float:
        """Return the arc length of the route at its end, m."""
        return self.arc_m + self.length_m

    @property
    def clear_m(self) -> tuple[float, float]:
        """Return the range of arc length in which it has walls all round, m."""
        return self.arc_m + self.taken_m[0], self.ends_m - self.taken_m[1]

    def frame_at(self, arc_m: float) -> Frame:
        """Return the frame of the centre line at an arc length of the route."""
        return self.frame.moved(arc_m - self.arc_m)

    def point(self, arc_m: float, aside_m: float = 0.0) -> Vector:
        """Return the point at an arc length, ``aside_m`` from the centre line towards side A."""
        return self.frame.point(arc_m - self.arc_m, aside_m)

    def beyond_m(self, point: Vector) -> float:
        """Return the distance of a point from the beginning, along the piece, m."""
        (px, py, pz), (x, y, z), (ax, ay, az) = point, self.frame.origin, self.frame.ahead
        return (px - x) * ax + (py - y) * ay + (pz - z) * az


class Route:
    """The pieces of a route through a network, in order.

    Args:
        network: The pipes.
        name: Name of the route; may be omitted if there is only one.

    Attributes:
        pieces: The pieces in order.
        crossings_m: Arc lengths at which axes intersect in a fitting.
        length_m: Length of the route.
        up: The unit vector opposite to gravity.

    Raises:
        ValueError: A run does not begin where its predecessor ends.
    """

    def __init__(self, network: Network, name: str = "") -> None:
        runs = network.routes[name or next(iter(network.routes))]
        self.pieces = tuple(_pieces([(run, network.runs[run]) for run in runs]))
        self.crossings_m = tuple(piece.ends_m for piece in self.pieces if piece.bend)
        self.length_m = self.pieces[-1].ends_m
        self.up = network.up

    def piece_at(self, arc_m: float) -> Piece:
        """Return the piece at an arc length; the first and the last extend without limit."""
        return next((piece for piece in self.pieces if arc_m <= piece.ends_m), self.pieces[-1])

    def frame_at(self, arc_m: float) -> Frame:
        """Return the frame of the centre line at an arc length."""
        return self.piece_at(arc_m).frame_at(arc_m)

    def arc_of(self, point: Vector) -> float:
        """Return the arc length of the nearest point of the centre line, m."""
        return self.nearest(point)[0]

    def nearest(self, point: Vector) -> tuple[float, float]:
        """Return the arc length of the nearest point of the centre line, and its distance, m."""
        nearest, found, last = inf, 0.0, len(self.pieces) - 1
        for number, piece in enumerate(self.pieces):
            along = piece.beyond_m(point)
            if number > 0:
                along = max(along, 0.0)
            if number < last:
                along = min(along, piece.length_m)
            away = dist(point, piece.frame.point(along))
            if away < nearest:
                nearest, found = away, piece.arc_m + along
        return found, nearest


class _Heading(NamedTuple):
    """The direction of travel: a plane, and the sum of the angles of the bends in it.

    The angles are summed before rotating, so that rounding errors do not accumulate from bend to
    bend.
    """

    plane: Frame = DRAWING
    turned_rad: float = 0.0

    @property
    def frame(self) -> Frame:
        return self.plane.turned(self.turned_rad)

    def after(self, mitre: Mitre) -> _Heading:
        if not mitre.roll_rad:
            return self._replace(turned_rad=self.turned_rad + mitre.angle_rad)
        frame = self.frame.rolled(mitre.roll_rad).turned(mitre.angle_rad)
        return _Heading(frame.rolled(-mitre.roll_rad))


def _pieces(runs: Sequence[tuple[str, Run]]) -> Iterator[Piece]:
    """Yield the pieces of consecutive runs."""
    heading, origin, arc, before = _Heading(), DRAWING.origin, 0.0, ""
    for name, run in runs:
        if before and run.begins != before:
            raise ValueError(f"run '{name}' begins at '{run.begins}', not at '{before}'")
        before, length, taken, first = run.ends, 0.0, 0.0, 0
        for number, segment in enumerate((*run.segments, None)):
            if isinstance(segment, Straight):
                length += segment.length_m
                continue
            after = segment.taken_m(run.diameter_m) if segment else 0.0
            frame, ends = heading.frame._replace(origin=origin), (taken, after)
            diameter, section = run.diameter_m, run.section
            yield Piece(frame, length, arc, diameter, ends, segment, name, first, section)
            origin, arc = frame.point(length), arc + length
            length, taken, first = 0.0, after, number + 1
            heading = heading.after(segment) if segment else heading
