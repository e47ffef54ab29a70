"""The joints of a route: where its pipe turns, opens or changes its diameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import nan, pi, tan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._geometry.network import BRANCH, port_of
from pirate_sm.core._geometry.piece import Piece
from pirate_sm.core._geometry.space import Frame, Vector

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
