"""The room for the centre of a wheel in pipes, and how far a point is outside of it.

A wheel is a sphere, so its centre keeps its radius away from a wall. Over the edge of a mitre or of
a tee's mouth it rolls from one wall to the other, and comes nearer to both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import hypot, inf
from operator import itemgetter
from typing import NamedTuple, Self

from pirate_sm.core.geometry import Piece, Route, Vector, between, combined, dot, port_of, scaled

_OPPOSITE = -0.5
"""Two runs at a tee whose directions have a lesser product go straight on."""


class _Tube(NamedTuple):
    """A piece of pipe, and the range along it in which its walls bound a wheel."""

    piece: Piece
    least_m: float
    most_m: float

    def outside_m(self, point: Vector, wheel_m: float) -> float:
        """Return how far a wheel's centre is outside; negative inside."""
        piece = self.piece
        away_m, along_m = piece.nearest(point, -inf, inf)
        aside_m = away_m - piece.diameter_at(piece.arc_m + along_m) / 2 + wheel_m
        if self.least_m <= along_m <= self.most_m:
            return aside_m
        return hypot(max(aside_m, 0.0), max(self.least_m - along_m, along_m - self.most_m))


class _Edge(NamedTuple):
    """The edge between the walls of two tubes that meet at an angle.

    Attributes:
        tubes: The tubes.
        corner: Where their axes meet.
        inward: The sum of their directions, from there.
    """

    tubes: tuple[_Tube, _Tube]
    corner: Vector
    inward: Vector

    def outside_m(self, point: Vector, wheel_m: float) -> float:
        """Return how far a wheel is in the edge that it rolls over; infinite beside it."""
        if dot(between(self.corner, point), self.inward) <= 0.0:
            return inf
        left_m = [wheel_m - tube.outside_m(point, wheel_m) for tube in self.tubes]
        return wheel_m - hypot(*left_m) if min(left_m) > 0.0 else inf


@dataclass(frozen=True)
class Room:
    """The room for the wheels of a robot.

    Attributes:
        wheel_m: Radius of the wheels.
        tubes: The pipes.
        edges: The edges where they meet.
    """

    wheel_m: float
    tubes: tuple[_Tube, ...]
    edges: tuple[_Edge, ...]

    @classmethod
    def of(cls, route: Route, wheel_radius_m: float) -> Self:
        """Return the room in all pipes of the network that a route leads through."""
        runs = {
            name: tuple(_tubes(pieces, wheel_radius_m, _loose(route, name)))
            for name, pieces in route.placement.runs.items()
        }
        mitres = [edge for tubes in runs.values() for edge in _mitres(tubes)]
        tees = [edge for name in route.placement.tees for edge in _mouth(route, name, runs)]
        tubes = tuple(tube for run in runs.values() for tube in run)
        return cls(wheel_radius_m, tubes, (*mitres, *tees))

    def near(self, point: Vector, reach_m: float) -> Room:
        """Return the same room within reach of a point, the nearest pipes first."""
        away = [(t.piece.nearest(point, t.least_m, t.most_m)[0], t) for t in self.tubes]
        reached = sorted((each for each in away if each[0] <= reach_m), key=itemgetter(0))
        tubes = tuple(tube for _, tube in reached)
        edges = tuple(edge for edge in self.edges if not set(edge.tubes).isdisjoint(tubes))
        return Room(self.wheel_m, tubes, edges)

    def outside_m(self, point: Vector, near_m: float = 0.0) -> float:
        """Return how far the centre of a wheel would be in a wall, m; 0 where there is room.

        Args:
            point: The centre.
            near_m: A result up to this may be too large.
        """
        nearest = inf
        for tube in self.tubes:
            outside_m = tube.outside_m(point, self.wheel_m)
            if outside_m <= near_m:
                return max(outside_m, 0.0)
            nearest = min(nearest, outside_m)
        for edge in self.edges:
            nearest = min(nearest, edge.outside_m(point, self.wheel_m))
        return max(nearest, 0.0)


def _tubes(pieces: Sequence[Piece], wheel_m: float, loose: tuple[bool, bool]) -> tuple[_Tube, ...]:
    """Return the tubes of a run, which goes on without limit at ends where it meets nothing."""
    tubes = []
    for piece in pieces:
        # The outer wall goes on beyond a mitre by what its cut takes of the inner wall.
        share = 1.0 - wheel_m / (piece.diameter_m / 2)
        before_m, behind_m = (taken_m * share for taken_m in piece.taken_m)
        tubes.append(_Tube(piece, -before_m, piece.length_m + behind_m))
    if loose[0]:
        tubes[0] = tubes[0]._replace(least_m=-inf)
    if loose[1]:
        tubes[-1] = tubes[-1]._replace(most_m=inf)
    return tuple(tubes)


class _Arm(NamedTuple):
    """A tube that begins or ends where it meets others."""

    tube: _Tube
    begins: bool

    @property
    def out(self) -> Vector:
        """Return the direction in which it leaves that place."""
        piece = self.tube.piece
        ahead = piece.frame.ahead
        return ahead if self.begins else scaled(-1.0, piece.frame_at(piece.ends_m).ahead)


def _edge(corner: Vector, one: _Arm, other: _Arm) -> _Edge:
    return _Edge((one.tube, other.tube), corner, combined((1.0, one.out), (1.0, other.out)))


def _mitres(tubes: Sequence[_Tube]) -> Iterator[_Edge]:
    """Yield the edges of the mitres of a run."""
    for before, after in pairwise(tubes):
        if before.piece.bend is not None:
            corner = after.piece.frame.origin
            yield _edge(corner, _Arm(before, begins=False), _Arm(after, begins=True))


def _mouth(route: Route, tee: str, runs: Mapping[str, Sequence[_Tube]]) -> Iterator[_Edge]:
    """Yield the edges of the mouth of a tee."""
    arms = [
        _Arm(runs[name][0 if begins else -1], begins)
        for name, begins in route.network.meet_at(tee)
        if name in runs
    ]
    for one, other in combinations(arms, 2):
        if dot(one.out, other.out) > _OPPOSITE:
            yield _edge(route.placement.tees[tee].origin, one, other)


def _loose(route: Route, run: str) -> tuple[bool, bool]:
    """Return whether a run meets no other one, and no cap, where it begins and where it ends."""
    network, own = route.network, route.network.runs[run]

    def loose(end: str) -> bool:
        junction = port_of(end)[0]
        return junction not in network.closed and len(network.meet_at(junction)) < 2

    return loose(own.begins), loose(own.ends)
