"""Pictures of pipes in space: their walls as rings of points, and views of these.

A wall is a strip of rings, each with as many points as the next; it lies between neighbouring
rings, and between neighbouring points of each, the last one beside the first. Pieces end at the
ellipse of a mitre; at a tee the branch ends at the mouth, and a collar with the mouth cut out
replaces the run. Views are from above, from the side, and unrolled along the way.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from math import asin, atan2, ceil, cos, inf, pi, sin, sqrt
from typing import NamedTuple, TypeAlias

from pirate_sm.core.geometry import (
    BRANCH,
    DRAWING,
    Frame,
    Network,
    Piece,
    Place,
    Placement,
    Route,
    Vector,
    Walls,
    between,
    combined,
    crossed,
    dot,
    port_of,
    scaled,
)

# --- walls ------------------------------------------------------------------------------------


Ring: TypeAlias = tuple[Vector, ...]
Rings: TypeAlias = tuple[Ring, ...]

AROUND = 48
"""Points of a ring; a multiple of 8, so that the corners of a collar are among them."""

_BEND_RAD = pi / 24
"""The most that an elbow turns between two rings."""

_COLLAR = 1.25
"""Half the length of a collar, in radii of its branch."""

_COLLAR_RINGS = 10


class Trim(NamedTuple):
    """What is left out at an end of a run, because a tee is there.

    Attributes:
        back_m: By how much its end is moved back.
        tee: Frame of the tee into whose side it opens; None for a plain end.
        along_m: Radius of that tee's run.
    """

    back_m: float = 0.0
    tee: Frame | None = None
    along_m: float = 0.0


def plain_tubes(placement: Placement) -> Iterator[Rings]:
    """Yield the rings of each piece of pipe; at a tee all of them reach to where the axes meet."""
    for pieces in placement.runs.values():
        yield from _run_rings(pieces, Trim(), Trim())


def walls_in_space(network: Network, placement: Placement) -> Iterator[Rings]:
    """Yield the walls of all pipes of a network, with mouths at tees and caps at closed ends."""
    bores = {name: _bores(network, placement, name) for name in placement.tees}

    def trim(at: str) -> Trim:
        junction, port = port_of(at)
        if junction not in bores:
            return Trim()
        along_m, branch_m = bores[junction]
        if port == BRANCH:
            return Trim(tee=placement.tees[junction], along_m=along_m)
        return Trim(_COLLAR * branch_m)

    for name, pieces in placement.runs.items():
        run = network.runs[name]
        begins, ends = trim(run.begins), trim(run.ends)
        yield from _run_rings(pieces, begins, ends)
        if run.begins in network.closed:
            yield _cap(pieces[0].frame, pieces[0].diameter_m / 2)
        if run.ends in network.closed:
            last = pieces[-1]
            yield _cap(last.frame_at(last.ends_m), last.ends_with_m / 2)
    for name, frame in placement.tees.items():
        yield _collar(frame, *bores[name])


def _bores(network: Network, placement: Placement, tee: str) -> tuple[float, float]:
    """Return the radius of a tee's run and of its branch, m."""
    along_m, branch_m = 0.0, 0.0
    for name, begins in network.meet_at(tee):
        run, pieces = network.runs[name], placement.runs.get(name)
        if pieces is None:
            continue
        radius_m = (pieces[0].diameter_m if begins else pieces[-1].ends_with_m) / 2
        if port_of(run.begins if begins else run.ends)[1] == BRANCH:
            branch_m = radius_m
        else:
            along_m = radius_m
    return along_m or branch_m, min(branch_m or along_m, along_m or inf)


def _run_rings(pieces: Sequence[Piece], begins: Trim, ends: Trim) -> Iterator[Rings]:
    """Yield the rings of each piece of a run."""
    last = len(pieces) - 1
    for number, piece in enumerate(pieces):
        before, after = pieces[max(number - 1, 0)], pieces[min(number + 1, last)]
        cut = _cut(before, piece) if number else None
        next_cut = _cut(piece, after) if number < last else None
        yield _piece_rings(
            piece,
            (begins if number == 0 else Trim(), cut),
            (ends if number == last else Trim(), next_cut),
        )


def _cut(before: Piece, after: Piece) -> Vector | None:
    """Return the normal of the plane between two pieces; None where there is no mitre."""
    if before.bend is None:
        return None
    return combined((1.0, before.frame.ahead), (1.0, after.frame.ahead))


_End = tuple[Trim, Vector | None]


def _piece_rings(piece: Piece, begins: _End, ends: _End) -> Rings:
    arcs_m = [piece.arc_m, piece.ends_m]
    if piece.arc is not None:
        steps = ceil(piece.arc.angle_rad / _BEND_RAD)
        arcs_m = [piece.arc_m + piece.length_m * n / steps for n in range(steps + 1)]
    arcs_m[0] += begins[0].back_m
    arcs_m[-1] -= ends[0].back_m
    radii = [piece.diameter_at(arc_m) / 2 for arc_m in arcs_m]
    radii[0] = piece.diameter_m / 2
    rings = [
        _ring(piece.frame_at(arc_m), radius_m, None)
        for arc_m, radius_m in zip(arcs_m, radii, strict=True)
    ]
    for number, (trim, cut) in ((0, begins), (-1, ends)):
        frame = piece.frame_at(arcs_m[number])
        if trim.tee is not None:
            rings[number] = _mouth(frame, radii[number], trim.tee, trim.along_m)
        elif cut is not None:
            rings[number] = _ring(frame, radii[number], cut)
    return tuple(rings)


def _ring(frame: Frame, radius_m: float, cut: Vector | None) -> Ring:
    """Return a ring about the axis, in the plane across it or with this normal."""
    found = []
    for number in range(AROUND):
        across = frame.towards(2 * pi * number / AROUND)
        along = 0.0 if cut is None else -radius_m * dot(across, cut) / dot(frame.ahead, cut)
        found.append(combined((1.0, frame.origin), (radius_m, across), (along, frame.ahead)))
    return tuple(found)


def _mouth(frame: Frame, radius_m: float, tee: Frame, along_m: float) -> Ring:
    """Return the edge at which a branch opens into the side of its run.

    Args:
        frame: The frame of the branch where the axes intersect.
        radius_m: Radius of the branch.
        tee: The frame of the tee.
        along_m: Radius of the run.
    """
    found = []
    for number in range(AROUND):
        across = frame.towards(2 * pi * number / AROUND)
        off_m = radius_m * dot(across, tee.normal)
        out_m = sqrt(max(along_m**2 - off_m**2, 0.0))
        found.append(combined((1.0, frame.origin), (radius_m, across), (out_m, tee.side)))
    return tuple(found)


def _collar(frame: Frame, along_m: float, branch_m: float) -> Rings:
    """Return the wall of a tee's run around the mouth of its branch.

    The wall is unrolled: the mouth's edge is a curve about the middle of a rectangle, whose sides
    are the collar's two ends and, twice, the line opposite to the mouth.
    """
    half_m = _COLLAR * branch_m
    inner, outer = [], []
    for number in range(AROUND):
        angle = 2 * pi * number / AROUND
        c, s = cos(angle), sin(angle)
        inner.append((branch_m * c, asin(max(-1.0, min(1.0, branch_m * s / along_m)))))
        longest = max(abs(c), abs(s))
        outer.append((half_m * c / longest, pi * s / longest))

    def ring(share: float) -> Ring:
        found = []
        for (x, turn), (far_x, far_turn) in zip(inner, outer, strict=True):
            across = frame.towards(turn + share * (far_turn - turn))
            ahead_m = x + share * (far_x - x)
            found.append(combined((1.0, frame.origin), (along_m, across), (ahead_m, frame.ahead)))
        return tuple(found)

    return tuple(ring(number / _COLLAR_RINGS) for number in range(_COLLAR_RINGS + 1))


def _cap(frame: Frame, radius_m: float) -> Rings:
    """Return the disc that closes an end."""
    return _ring(frame, radius_m, None), (frame.origin,) * AROUND


# --- views ------------------------------------------------------------------------------------


Outline: TypeAlias = tuple[Place, ...]
"""The corners of a convex area."""

_STRAIGHT = 1e-8
"""Corners that stick out by less are left out."""

_STEEP = 0.2
"""Sine of the angle to the vertical below which a pipe has no upper side."""


def unit(vector: Vector) -> Vector:
    """Return the vector with length 1."""
    return scaled(dot(vector, vector) ** -0.5, vector)


def upright(up: Vector) -> Frame:
    """Return the frame whose ``normal`` goes up and whose ``ahead`` is level.

    ``ahead`` is that of the drawing as seen from above, or its side A if the first run is upright.
    ``side`` is on the left.
    """
    ahead = DRAWING.ahead if abs(up[0]) < 1.0 - 1e-6 else DRAWING.side
    level = combined((1.0, ahead), (-dot(ahead, up), up))
    level = unit(level)
    return Frame(DRAWING.origin, level, crossed(up, level), up)


def seen_in(frame: Frame, point: Vector) -> Vector:
    """Return the coordinates of a point, or of a direction, along the axes of a frame."""
    return dot(point, frame.ahead), dot(point, frame.side), dot(point, frame.normal)


def outlines(tubes: Iterable[Rings], axes: tuple[int, int]) -> tuple[Outline, ...]:
    """Return convex areas that together are what is seen of pipes along the third axis.

    Args:
        tubes: The rings of each piece of pipe.
        axes: The two axes of the picture.
    """
    one, other = axes
    return tuple(
        _hull([(point[one], point[other]) for ring in pair for point in ring])
        for rings in tubes
        for pair in pairwise(rings)
    )


def _hull(points: Sequence[Place]) -> Outline:
    """Return the convex hull of points, counter-clockwise (A. M. Andrew, 1979)."""
    ordered = sorted({(round(x, 6), round(y, 6)) for x, y in points})
    return (*_chain(ordered)[:-1], *_chain(ordered[::-1])[:-1])


def _chain(points: Sequence[Place]) -> list[Place]:
    found: list[Place] = []
    for x, y in points:
        while len(found) > 1:
            (ax, ay), (bx, by) = found[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > _STRAIGHT:
                break
            found.pop()
        found.append((x, y))
    return found


def unrolled(route: Route, point: Vector, roll_rad: float) -> Place:
    """Return how far a point is along a route, and how far to side A of a part so rolled, m."""
    arc_m, _ = route.nearest(point)
    frame = route.frame_at(arc_m)
    return arc_m, dot(between(frame.origin, point), frame.towards(roll_rad))


def unrolled_walls(route: Route) -> Walls:
    """Return the walls of a route on either side of its unrolled axis, m."""
    first = route.pieces[0]
    one = [(first.arc_m, first.diameter_m / 2)]
    for piece in route.pieces:
        for corner in (piece.arc_m, piece.diameter_m / 2), (piece.ends_m, piece.ends_with_m / 2):
            if corner != one[-1]:
                one.append(corner)
    return tuple(one), tuple((x, -y) for x, y in one)


def clock_rad(route: Route, arc_m: float, roll_rad: float) -> float:
    """Return where a direction across a route points, looking ahead: 0 right, 90 deg up.

    In an upright pipe, which has no upper side, it is the roll against the frame of the pipe.

    Args:
        route: The route.
        arc_m: Where on it.
        roll_rad: Roll of the direction about the direction of travel; 0 is towards side A.
    """
    frame = route.frame_at(arc_m)
    across = combined((1.0, route.up), (-dot(route.up, frame.ahead), frame.ahead))
    if dot(across, across) < _STEEP**2:
        return roll_rad
    highest = frame.roll_of(across)
    direction = frame.rolled(highest).roll_of(frame.towards(roll_rad))
    return atan2(1.0, 0.0) + direction


# --- the planes of the two parts of a robot in space ------------------------------------------


def part_normals(
    route: Route, points: Sequence[Vector], rear: int, rolls_rad: Sequence[float]
) -> tuple[Vector, Vector]:
    """Return the unit normals of the front and of the rear part, square to the link between them.

    Args:
        route: The route through the pipes.
        points: Position of each wheel in the frame of the drawing, m.
        rear: Index of the first wheel of the rear part.
        rolls_rad: Roll of the front and of the rear part against the frame of the pipe where the
            link between them begins and ends.
    """
    ahead = unit(combined((1.0, points[rear - 1]), (-1.0, points[rear])))
    front, behind = (
        _square(route.frame_at(route.arc_of(points[wheel])).rolled(roll_rad).normal, ahead)
        for wheel, roll_rad in zip((rear - 1, rear), rolls_rad, strict=True)
    )
    return front, behind


def _square(vector: Vector, ahead: Vector) -> Vector:
    """Return the unit vector square to ``ahead`` that is nearest to a unit vector.

    A pipe that turns by a right angle within the link leaves none; then it stays as it is.
    """
    across = combined((1.0, vector), (-dot(vector, ahead), ahead))
    return unit(across) if dot(across, across) > 0.0 else vector
