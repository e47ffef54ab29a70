"""A route through a network: arc length ↔ point, frame and diameter; its joints and walls.

A joint is where the pipe turns, opens or changes its diameter. Walls are drawn in the plane of the
drawing, a projection of space whose axes are x and y (:mod:`pirate_sm.core._geometry.space`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import cos, inf, nan, pi, sin, tan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._geometry.network import BRANCH, Network, Piece, port_of
from pirate_sm.core._geometry.placement import meeting, place
from pirate_sm.core._geometry.space import Frame, Place, Vector

# --- joints -----------------------------------------------------------------------------------


JointKind: TypeAlias = Literal["mitre", "elbow", "tee", "reducer"]
JointOrEnd: TypeAlias = Literal["mitre", "elbow", "tee", "reducer", "end"]
"""What may be ahead of a robot on its route: a joint, or where the pipe ends."""


class RouteJoint(NamedTuple):
    """A fitting or a junction on a route.

    Attributes:
        kind: What it is.
        arc_m: Where the axes intersect; of an elbow its middle, of a reducer its beginning.
        before_m: How far before this the walls are no longer those of a plain pipe.
        behind_m: How far behind.
        turn_rad: By how much the route turns there; 0 straight on.
        towards_rad: Towards where it turns, or where the opening of a tee is that it passes: the
            roll about the direction of travel; NaN for a reducer.
        junction: Name of the tee; empty for a fitting.
    """

    kind: JointKind
    arc_m: float
    before_m: float
    behind_m: float
    turn_rad: float = 0.0
    towards_rad: float = nan
    junction: str = ""


class Bend(NamedTuple):
    """Where a route turns, as detectors count it.

    Attributes:
        crossing_m: Where the axes intersect; of an elbow its middle.
        reach_m: How far from there the crossings are of two mitres that take as much wall as the
            elbow's beginning and its end; 0 for a mitre and for a tee.
    """

    crossing_m: float
    reach_m: float = 0.0


def bend_at(joint: RouteJoint, diameter_m: float) -> Bend:
    """Return a joint that turns as detectors count it, in a pipe of this diameter."""
    if joint.kind != "elbow":
        return Bend(joint.arc_m)
    half_turn = min(joint.turn_rad / 2, pi / 4)
    return Bend(joint.arc_m, max(joint.behind_m - diameter_m / 2 * tan(half_turn), 0.0))


class Passage(NamedTuple):
    """A run on a route.

    Attributes:
        run: Its name.
        forward: Whether the route passes it from its beginning to its end.
        comes: Where the route enters it.
        goes: Where the route leaves it.
    """

    run: str
    forward: bool
    comes: str
    goes: str


def joints_of(
    pieces: Sequence[Piece], passages: Sequence[Passage], tees: Mapping[str, Frame]
) -> Iterator[RouteJoint]:
    """Yield the joints of a route in order.

    Args:
        pieces: The pieces of the route.
        passages: Its runs.
        tees: The frames of the tees in the network.
    """
    changes = {before.run: (before, after) for before, after in pairwise(passages)}
    yield from _fitting(pieces[0])
    for before, after in pairwise(pieces):
        if before.run != after.run:
            out, into = changes[before.run]
            junction, port = port_of(out.goes)
            ports = (port, port_of(into.comes)[1])
            if junction in tees:
                yield _tee(before, after, ports, tees[junction], junction)
                continue
        if before.bend is not None:
            yield _mitre(before, after)
        elif after.diameter_m != before.ends_with_m:
            yield RouteJoint("reducer", after.arc_m, 0.0, 0.0)
        yield from _fitting(after)


def _fitting(piece: Piece) -> Iterator[RouteJoint]:
    """Yield the joint that a piece is, if it is one."""
    if piece.arc is not None:
        half, towards = piece.length_m / 2, piece.frame.roll_of(piece.arc.towards)
        yield RouteJoint("elbow", piece.arc_m + half, half, half, piece.arc.angle_rad, towards)
    elif piece.ends_with_m != piece.diameter_m:
        yield RouteJoint("reducer", piece.arc_m, 0.0, piece.length_m)


def _mitre(before: Piece, after: Piece) -> RouteJoint:
    assert before.bend is not None  # as joints_of has seen
    towards = _towards(before, after.frame.ahead)
    taken = before.taken_m[1]
    return RouteJoint("mitre", before.ends_m, taken, taken, abs(before.bend.angle_rad), towards)


def _tee(
    before: Piece, after: Piece, ports: tuple[str, str], frame: Frame, junction: str
) -> RouteJoint:
    """Return the joint of a tee that a route passes from one port to another."""
    before_m, behind_m = after.diameter_m / 2, before.ends_with_m / 2
    if BRANCH not in ports:
        return RouteJoint(
            "tee", before.ends_m, before_m, behind_m, 0.0, _towards(before, frame.side), junction
        )
    towards = _towards(before, after.frame.ahead)
    return RouteJoint("tee", before.ends_m, before_m, behind_m, pi / 2, towards, junction)


def _towards(piece: Piece, direction: Vector) -> float:
    """Return the roll of a direction at the end of a piece."""
    return piece.frame_at(piece.ends_m).roll_of(direction)


# --- the route --------------------------------------------------------------------------------


_SAME_RAD = 1e-9


class Route:
    """The pieces of a route through a network, in order.

    Args:
        network: The pipes.
        name: Name of the route; may be omitted if there is only one.

    Attributes:
        network: The pipes.
        placement: Where all pipes of the network are.
        pieces: The pieces in order.
        joints: The fittings and junctions in order.
        crossings_m: Arc lengths at which it turns in a fitting or a junction.
        bends: The same places, with how far elbows reach.
        length_m: Length of the route.
        ends: Where it begins and where it ends.
        up: The unit vector opposite to gravity.
        section: What the walls of its first run are.

    Raises:
        ValueError: Two runs that follow each other do not meet.
    """

    def __init__(self, network: Network, name: str = "") -> None:
        runs = network.routes[name or next(iter(network.routes))]
        self.network, self.placement = network, place(network)
        passages = passages_of(network, runs)
        self.pieces = tuple(_carried(self._strung(passages)))
        first, last = self.pieces[0], self.pieces[-1]
        self._stretches = [  # the first and the last extend without limit
            (piece, -inf if piece is first else 0.0, inf if piece is last else piece.length_m)
            for piece in self.pieces
        ]
        self.joints = tuple(joints_of(self.pieces, passages, self.placement.tees))
        turning = [joint for joint in self.joints if joint.turn_rad]
        self.crossings_m = tuple(joint.arc_m for joint in turning)
        self.length_m = self.pieces[-1].ends_m
        self.ends = passages[0].comes, passages[-1].goes
        self._begins = dict(self._run_begins(passages))
        self.up = network.up
        self.bends = tuple(bend_at(each, self.diameter_at(each.arc_m)) for each in turning)
        self.section = self.pieces[0].section

    def piece_at(self, arc_m: float) -> Piece:
        """Return the piece at an arc length; the first and the last extend without limit."""
        for piece in self.pieces:
            if arc_m <= piece.arc_m + piece.length_m:
                return piece
        return self.pieces[-1]

    def frame_at(self, arc_m: float) -> Frame:
        """Return the frame of the centre line at an arc length."""
        return self.piece_at(arc_m).frame_at(arc_m)

    def diameter_at(self, arc_m: float) -> float:
        """Return the inner diameter at an arc length, m."""
        return self.piece_at(arc_m).diameter_at(arc_m)

    def arc_in(self, run: str, along_m: float) -> float:
        """Return the arc length of a place in a run of the route, m from the run's beginning."""
        begin, forward = self._begins[run]
        return begin + along_m if forward else begin - along_m

    def arc_of(self, point: Vector) -> float:
        """Return the arc length of the nearest point of the centre line, m."""
        return self.nearest(point)[0]

    def nearest(self, point: Vector) -> tuple[float, float]:
        """Return the arc length of the nearest point of the centre line, and its distance, m."""
        nearest, found = inf, 0.0
        for piece, least, most in self._stretches:
            away, along = piece.nearest(point, least, most)
            if away < nearest:
                nearest, found = away, piece.arc_m + along
        return found, nearest

    def _run_begins(self, passages: Sequence[Passage]) -> Iterator[tuple[str, tuple[float, bool]]]:
        """Yield for each run the arc length of its beginning, and whether it is passed forward."""
        for name, forward, _, _ in passages:
            own = [piece for piece in self.pieces if piece.run == name]
            yield name, (own[0].arc_m if forward else own[-1].ends_m, forward)

    def _strung(self, passages: Sequence[Passage]) -> Iterator[Piece]:
        """Yield the pieces of the runs in order, with arc lengths of the route."""
        arc_m = 0.0
        for passage in passages:
            for piece in _directed(self.placement.runs[passage.run], passage.forward):
                yield piece._replace(arc_m=arc_m)
                arc_m += piece.length_m


def passages_of(network: Network, runs: Sequence[str]) -> tuple[Passage, ...]:
    """Return the runs of a route with their directions.

    Raises:
        ValueError: Two runs that follow each other do not meet.
    """
    return tuple(_passages(network, runs))


def _passages(network: Network, runs: Sequence[str]) -> Iterator[Passage]:
    """Yield the runs of a route with their directions."""
    before = ""
    for name, after in zip(runs, (*runs[1:], ""), strict=True):
        forth = _forth(network, name)
        possible = [forth, forth._replace(forward=False, comes=forth.goes, goes=forth.comes)]
        if before:
            possible = [each for each in possible if _meet(network, before, each.comes)]
        elif after:
            ends = _forth(network, after)[2:]
            possible = [
                each for each in possible if any(_meet(network, each.goes, end) for end in ends)
            ] or possible
        if not possible:
            raise ValueError(f"run '{name}' does not begin or end at '{before}'")
        before = possible[0].goes
        yield possible[0]


def _forth(network: Network, name: str) -> Passage:
    return Passage(name, True, network.runs[name].begins, network.runs[name].ends)


def _meet(network: Network, one: str, other: str) -> bool:
    """Return whether two ends of runs meet in a junction."""
    junction = port_of(one)[0]
    if junction in network.tees:
        return one != other and junction == port_of(other)[0]
    return one == other


def _directed(pieces: Sequence[Piece], forward: bool) -> Sequence[Piece]:
    """Return the pieces of a run in the order and direction in which a route passes them."""
    if forward:
        return pieces
    bends = (None, *(piece.bend for piece in pieces[:-1]))
    turned = zip(reversed(pieces), reversed(bends), strict=True)
    return [
        piece.turned_round(bend and replace(bend, angle_rad=-bend.angle_rad))
        for piece, bend in turned
    ]


def _carried(pieces: Iterator[Piece]) -> Iterator[Piece]:
    """Yield the pieces with frames that are carried along the route without twist."""
    before: Piece | None = None
    for piece in pieces:
        if before is not None:
            carried = before.frame_at(before.ends_m).led_to(piece.frame.ahead)
            twist = piece.frame.roll_of(carried.side)
            if abs(twist) > _SAME_RAD:
                piece = piece.twisted(twist)  # noqa: PLW2901
        before = piece
        yield before


# --- walls, as they are drawn -----------------------------------------------------------------


Walls: TypeAlias = tuple[tuple[Place, ...], tuple[Place, ...]]

_FLAT = 1e-9


def flat(point: Vector) -> Place:
    """Return the projection of a point into the plane of the drawing."""
    return point[0], point[1]


def turned(place: Place, angle_rad: float) -> Place:
    """Return a point rotated about the origin, from x to y."""
    (x, y), c, s = place, cos(angle_rad), sin(angle_rad)
    return x * c - y * s, x * s + y * c


def walls(route: Route) -> Walls:
    """Return the corners of the walls of a planar route on side A and on side B, m."""
    return _wall(route, 1.0), _wall(route, -1.0)


def drawn_walls(route: Route) -> tuple[tuple[Place, ...], ...]:
    """Return the walls of a route that lies in the plane of the drawing; empty for others.

    A route with elbows or changes of its diameter has no such walls either.
    """
    flat_pieces = all(
        abs(piece.frame.ahead[2]) < _FLAT
        and abs(piece.frame.origin[2]) < _FLAT
        and piece.arc is None
        and piece.ends_with_m == piece.diameter_m == route.pieces[0].diameter_m
        for piece in route.pieces
    )
    return walls(route) if flat_pieces else ()


def _wall(route: Route, side: float) -> tuple[Place, ...]:
    first, last = route.pieces[0], route.pieces[-1]
    corners = [flat(first.frame.point(0.0, side * first.diameter_m / 2))]
    for before, after in pairwise(route.pieces):
        (ax, ay), (bx, by) = flat(before.frame.ahead), flat(after.frame.ahead)
        x, y = flat(after.frame.origin)
        # The intersection of the two lines parallel to the centre line.
        share = side * before.diameter_m / 2 / (1.0 + ax * bx + ay * by)
        corners.append((x - share * (ay + by), y + share * (ax + bx)))
    corners.append(flat(last.frame.point(last.length_m, side * last.diameter_m / 2)))
    return tuple(corners)


def inner_corner(route: Route) -> Place:
    """Return the inner corner of a route's first bend; of a straight one where side A begins.

    It is the origin of the plane of a setup (thesis section 5-3-2), whose x points along the first
    leg and whose y points to side A.
    """
    side_a, side_b = walls(route)
    if len(route.pieces) == 1:
        return side_a[0]
    (ax, ay), (bx, by) = (flat(piece.frame.ahead) for piece in route.pieces[:2])
    return side_a[1] if ax * by - ay * bx > 0 else side_b[1]


def crossing(route: Route) -> tuple[Piece, Piece] | None:
    """Return the first two pieces of a planar route that overlap, None if there are none.

    Adjacent pieces meet at their fitting and are not compared.
    """
    side_a, side_b = walls(route)
    corners = pairwise(zip(side_a, side_b, strict=True))
    shapes = [(a, b, beyond_b, beyond_a) for (a, b), (beyond_a, beyond_b) in corners]
    for i, k in meeting(shapes, [0.0] * len(shapes)):
        if k - i > 1 and _overlap(shapes[i], shapes[k]):
            return route.pieces[i], route.pieces[k]
    return None


def _overlap(one: Sequence[Place], other: Sequence[Place]) -> bool:
    """Return whether two convex polygons overlap, by the separating axis theorem."""
    for shape in (one, other):
        for (ax, ay), (bx, by) in zip(shape, (*shape[1:], shape[0]), strict=True):
            first = [(by - ay) * x - (bx - ax) * y for x, y in one]
            second = [(by - ay) * x - (bx - ax) * y for x, y in other]
            if max(first) <= min(second) + 1e-12 or max(second) <= min(first) + 1e-12:
                return False
    return True
