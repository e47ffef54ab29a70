"""A route through round pipes as arrays for the kernel: its solids, edges and centre line."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pirate_sm.geometry.route import Piece, Route
from pirate_sm.geometry.space import Frame, Vector
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.xpbd.space.edges import Edge, edge_rows, mitre_edge, ring
from pirate_sm.simulation.xpbd.space.solids import Plane, Row, tube


class PipeShape(NamedTuple):
    """The shape of round pipes, as the kernel reads it.

    Attributes:
        solids: `(solids, kernel.SOLID_COLUMNS)`.
        edges: `(edges, kernel.EDGE_COLUMNS)`.
        points: `(points, kernel.POINT_COLUMNS)`, of all edges in turn.
        legs: `(lines, kernel.LEG_COLUMNS)`, the centre line.
    """

    solids: Floats
    edges: Floats
    points: Floats
    legs: Floats


def shape_of(solids: Sequence[Row], edges: Sequence[Edge], legs: Sequence[Row]) -> PipeShape:
    """Return the shape of pipes made of these solids, edges and lines."""
    return PipeShape(np.array(solids), *edge_rows(edges), np.array(legs))


def route_shape(route: Route) -> PipeShape:
    """Return the shape of a route of straight round pieces and mitres, open at both ends."""
    pieces = route.pieces
    solids = [
        tube(
            piece.frame, piece.length_m, piece.diameter_m / 2,
            first=_cut(pieces[number - 1], piece) if number > 0 else None,
            last=_cut(piece, pieces[number + 1]) if number < len(pieces) - 1 else None,
        )
        for number, piece in enumerate(pieces)
    ]  # fmt: skip
    edges = [
        mitre_edge(one.frame, other.frame, one.diameter_m / 2, (number, number + 1))
        for number, (one, other) in enumerate(pairwise(pieces))
    ]
    first, last = pieces[0], pieces[-1]
    end = last.frame.moved(last.length_m)
    edges.append(ring(first.frame, first.diameter_m / 2, (0, -1)))
    edges.append(ring(end, last.diameter_m / 2, (len(pieces) - 1, -1)))
    return shape_of(solids, edges, [line(each.frame, each.length_m, each.arc_m) for each in pieces])


def line(frame: Frame, length_m: float, arc_m: float, stretch: float = 1.0) -> Row:
    """Return a straight part of the centre line.

    Args:
        frame: Its beginning.
        length_m: Its length.
        arc_m: Arc length of the route at its beginning.
        stretch: Arc length per length; more than 1 for a chord of an elbow.
    """
    return np.array([*frame.origin, *frame.ahead, length_m, arc_m, stretch, *frame.side])


def _cut(before: Piece, after: Piece) -> Plane:
    """Return the plane in which two pieces of a mitre meet."""
    (ax, ay, az), (bx, by, bz) = before.frame.ahead, after.frame.ahead
    across: Vector = (ax + bx, ay + by, az + bz)
    return Plane(after.frame.origin, across)
