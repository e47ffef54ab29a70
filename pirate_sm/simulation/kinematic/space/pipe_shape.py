"""The pipes of a network as arrays for the kernel: solids, edges and a route's centre line."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from pirate_sm.core.geometry import (
    BRANCH,
    IN,
    ON,
    Frame,
    Network,
    Piece,
    Placement,
    Route,
    combined,
    port_of,
)
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic.space import columns
from pirate_sm.simulation.kinematic.space.solids import (
    Hole,
    Plane,
    Row,
    WallEdge,
    disc,
    edge_rows,
    elbow,
    mitre_edge,
    mouth,
    ring,
    tube,
)

_SAME_M = 1e-9


class PipeShape(NamedTuple):
    """The shape of round pipes, as the kernel reads it.

    Attributes:
        solids: `(solids, columns.SOLID_COLUMNS)`.
        edges: `(edges, columns.EDGE_COLUMNS)`.
        points: `(points, columns.POINT_COLUMNS)`, of all edges in turn.
        legs: `(pieces, columns.LEG_COLUMNS)`, the centre line.
    """

    solids: Floats
    edges: Floats
    points: Floats
    legs: Floats


class _End(NamedTuple):
    """An end of a run: the run, its last piece there, and the frame there, pointing out of it."""

    run: str
    piece: Piece
    frame: Frame
    radius_m: float
    begins: bool


def shape_of(route: Route) -> PipeShape:
    """Return the shape of all pipes of a route's network, and the route's centre line."""
    builder = _Builder(route.network, route.placement)
    return PipeShape(
        np.array(builder.solids), *edge_rows(builder.edges), np.array(_legs(route.pieces))
    )


class _Builder:
    """Makes the solids and edges of a network.

    Attributes:
        solids: The rows of the solids.
        edges: The edges.
    """

    def __init__(self, network: Network, placement: Placement) -> None:
        self.solids: list[Row] = []
        self.edges: list[WallEdge] = []
        self._tees = {
            name: _Tee(frame, _at_ports(network, placement, name))
            for name, frame in placement.tees.items()
        }
        self._numbers: dict[tuple[str, bool], int] = {}
        self._meetings: dict[str, list[_End]] = {}
        for name, pieces in placement.runs.items():
            run = network.runs[name]
            self._add_run(name, [each for each in pieces if each.length_m > 0.0])
            for end in _ends(name, pieces):
                at = run.begins if end.begins else run.ends
                self._meetings.setdefault(port_of(at)[0], []).append(end)
        for at, ends in self._meetings.items():
            if at in self._tees:
                self._add_mouth(self._tees[at], ends)
            else:
                self._add_end(ends, closed=at in network.closed)

    def _add_run(self, name: str, pieces: Sequence[Piece]) -> None:
        """Add the walls of a run, and what is where its pieces meet."""
        first = len(self.solids)
        self._numbers[name, True] = first
        self._numbers[name, False] = first + len(pieces) - 1
        around = (None, *pieces, None)
        for before, piece, after in zip(around, pieces, around[2:], strict=False):
            hole = next((hole for tee in self._tees.values() if (hole := tee.hole_of(piece))), None)
            self.solids.append(_walls(before, piece, after, hole))
        for number, (before, after) in enumerate(pairwise(pieces), start=first):
            if before.bend is not None:
                radius = before.ends_with_m / 2
                self.edges.append(
                    mitre_edge(before.frame, after.frame, radius, (number, number + 1))
                )
            else:
                self._add_change(before, after, number)

    def _add_change(self, before: Piece, after: Piece, number: int) -> None:
        """Add the step or the ring where two pieces about one axis meet."""
        narrow, wide = before.ends_with_m / 2, after.diameter_m / 2
        if abs(narrow - wide) > _SAME_M:
            self._add_step(after.frame, narrow, wide, (number, number + 1))
        elif _growth(after) > _growth(before):
            self.edges.append(ring(after.frame, narrow, (number, number + 1)))

    def _add_step(
        self, frame: Frame, before_m: float, after_m: float, solids: tuple[int, int]
    ) -> None:
        """Add the flat ring between two radii, and its inner edge."""
        face = frame if after_m > before_m else frame.reversed()
        number = len(self.solids)
        self.solids.append(disc(face, max(before_m, after_m), min(before_m, after_m)))
        narrow = solids[0] if after_m > before_m else solids[1]
        self.edges.append(ring(frame, min(before_m, after_m), (narrow, number)))

    def _add_end(self, ends: Sequence[_End], *, closed: bool) -> None:
        """Add what is at an end, or where two runs meet without a tee."""
        one = ends[0]
        number = self._numbers[one.run, one.begins]
        if len(ends) > 1:
            other = ends[1]
            if abs(one.radius_m - other.radius_m) > _SAME_M:
                numbers = (number, self._numbers[other.run, other.begins])
                self._add_step(one.frame, one.radius_m, other.radius_m, numbers)
        elif closed:
            self.solids.append(disc(one.frame.reversed(), one.radius_m))
        else:
            self.edges.append(ring(one.frame, one.radius_m, (number,)))

    def _add_mouth(self, tee: _Tee, ends: Sequence[_End]) -> None:
        """Add the edge of a tee, and a wall where one of its ports has no run."""
        if tee.branch is None:
            return
        main, branch = tee.main_hole, tee.branch_hole
        assert main is not None
        assert branch is not None
        numbers = tuple(self._numbers[end.run, end.begins] for end in ends)
        self.edges.append(mouth(main, branch, numbers))


class _Tee:
    """A tee and what meets there.

    Args:
        frame: Where the axes intersect; side towards the branch.
        ports: What is at each port.
    """

    def __init__(self, frame: Frame, ports: dict[str, _End]) -> None:
        self.branch = ports.get(BRANCH)
        mains = [ports[port] for port in (IN, ON) if port in ports]
        self._mains = {(end.run, end.piece.segment) for end in mains}
        self.main_hole = self.branch_hole = None
        if mains:
            radius = max(end.radius_m for end in mains)
            self.main_hole = Hole(frame.origin, frame.ahead, radius, whole=True)
        if self.branch is not None:
            self.branch_hole = Hole(frame.origin, frame.side, self.branch.radius_m)

    def hole_of(self, piece: Piece) -> Hole | None:
        """Return the hole that the tee makes into a piece; None where it makes none."""
        if self.branch is not None:
            if (piece.run, piece.segment) == (self.branch.run, self.branch.piece.segment):
                return self.main_hole
            if (piece.run, piece.segment) in self._mains:
                return self.branch_hole
        return None


def _at_ports(network: Network, placement: Placement, tee: str) -> dict[str, _End]:
    """Return the ends of runs at the ports of a tee."""
    found = {}
    for name, pieces in placement.runs.items():
        run = network.runs[name]
        for end in _ends(name, pieces):
            junction, port = port_of(run.begins if end.begins else run.ends)
            if junction == tee:
                found[port] = end
    return found


def _ends(name: str, pieces: Sequence[Piece]) -> tuple[_End, _End]:
    """Return both ends of a run."""
    first, last = pieces[0], pieces[-1]
    after = last.frame_at(last.ends_m)
    return (
        _End(name, first, first.frame.reversed(), first.diameter_m / 2, begins=True),
        _End(name, last, after, last.ends_with_m / 2, begins=False),
    )


def _walls(before: Piece | None, piece: Piece, after: Piece | None, hole: Hole | None) -> Row:
    """Return the walls of a piece between its neighbours."""
    if piece.arc is not None:
        return elbow(piece.frame, piece.arc, piece.diameter_m / 2, hole)
    return tube(
        piece.frame, piece.length_m, piece.diameter_m / 2, piece.ends_with_m / 2,
        first=_cut(before, piece) if before and before.bend else None,
        last=_cut(piece, after) if after and piece.bend else None,
        hole=hole,
    )  # fmt: skip


def _cut(before: Piece, after: Piece) -> Plane:
    """Return the plane in which the two pieces of a mitre meet."""
    across = combined((1.0, before.frame.ahead), (1.0, after.frame.ahead))
    return Plane(after.frame.origin, across)


def _growth(piece: Piece) -> float:
    """Return how much a piece's diameter grows along it."""
    return (piece.ends_with_m - piece.diameter_m) / piece.length_m


def _legs(pieces: Sequence[Piece]) -> list[Row]:
    """Return the centre line; before and behind elbows at its ends it goes on straight."""
    rows = [_leg(piece) for piece in pieces if piece.length_m > 0.0]
    first, last = pieces[0], pieces[-1]
    if first.arc is not None:
        rows.insert(0, _straight(first.frame, 0.0, first.arc_m))
    if last.arc is not None:
        rows.append(_straight(last.frame_at(last.ends_m), 0.0, last.ends_m))
    return rows


def _leg(piece: Piece) -> Row:
    row = _straight(piece.frame, piece.length_m, piece.arc_m)
    if piece.arc is not None:
        row[columns.C_RADIUS] = piece.arc.radius_m
        row[columns.C_UX : columns.C_UZ + 1] = piece.arc.towards
    return row


def _straight(frame: Frame, length_m: float, arc_m: float) -> Row:
    row = np.zeros(columns.LEG_COLUMNS)
    row[: columns.C_SZ + 1] = (*frame.origin, *frame.ahead, length_m, arc_m, *frame.side)
    return row
