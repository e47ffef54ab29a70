"""Whether the pipes of a network keep clear of each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, pairwise
from math import ceil, pi, sqrt

from pirate_sm.core._geometry.network import Network, port_of
from pirate_sm.core._geometry.piece import Piece
from pirate_sm.core._geometry.placement import Placement
from pirate_sm.core._geometry.space import Vector, between, combined, dot

_CHORD_RAD = pi / 12
"""An arc is looked at as chords of this angle."""

_TOUCH_M = 1e-3
"""Pipes that overlap by less only touch."""


def crossings(network: Network, placement: Placement) -> Iterator[tuple[Piece, Piece]]:
    """Yield the pairs of pieces whose pipes run into each other.

    Neighbours meet at their fitting or junction and are not compared. Next to its fittings a piece
    is shortened by its radius, since pipes that follow each other round a short bend touch there.
    """
    pieces = [piece for run in placement.runs.values() for piece in run]
    axes = [_axis(piece) for piece in pieces]
    meeting = _neighbours(network, placement)
    for (one, axis), (other, near) in combinations(zip(pieces, axes, strict=True), 2):
        if frozenset((id(one), id(other))) in meeting:
            continue
        least = (_widest(one) + _widest(other)) / 2 - _TOUCH_M
        if axis and near and _closer(axis, near, least):
            yield one, other


def _neighbours(network: Network, placement: Placement) -> set[frozenset[int]]:
    """Return the pairs of pieces that meet."""
    found = {
        frozenset((id(one), id(other)))
        for run in placement.runs.values()
        for one, other in pairwise(run)
    }
    at: dict[str, list[Piece]] = {}
    for name, pieces in placement.runs.items():
        run = network.runs[name]
        at.setdefault(port_of(run.begins)[0], []).append(pieces[0])
        at.setdefault(port_of(run.ends)[0], []).append(pieces[-1])
    for there in at.values():
        found |= {frozenset((id(one), id(other))) for one, other in combinations(there, 2)}
    return found


def _widest(piece: Piece) -> float:
    return max(piece.diameter_m, piece.ends_with_m)


def _axis(piece: Piece) -> list[Vector]:
    """Return points of a piece's shortened axis; none of a piece that is too short."""
    radius = _widest(piece) / 2
    first, last = piece.arc_m + radius, piece.ends_m - radius
    if last <= first:
        return []
    chords = 1 if piece.arc is None else ceil(piece.arc.angle_rad / _CHORD_RAD)
    step = (last - first) / chords
    return [piece.frame_at(first + n * step).origin for n in range(chords + 1)]


def _closer(one: Sequence[Vector], other: Sequence[Vector], least_m: float) -> bool:
    """Return whether two lines come closer than this."""
    return any(apart_m(a, b, c, d) < least_m for a, b in pairwise(one) for c, d in pairwise(other))


def apart_m(a: Vector, b: Vector, c: Vector, d: Vector) -> float:
    """Return the distance of the straight from a to b from that from c to d, m.

    The nearest points of the two lines, clipped to their ends one after the other (Ericson,
    Real-Time Collision Detection, section 5.1.9).
    """
    u, v, w = between(a, b), between(c, d), between(c, a)
    uu, vv, uv, uw, vw = dot(u, u), dot(v, v), dot(u, v), dot(u, w), dot(v, w)
    across = uu * vv - uv * uv
    s = min(max((uv * vw - uw * vv) / across, 0.0), 1.0) if across > 1e-12 * uu * vv else 0.0
    t = (uv * s + vw) / vv
    if not 0.0 <= t <= 1.0:
        t = min(max(t, 0.0), 1.0)
        s = min(max((uv * t - uw) / uu, 0.0), 1.0)
    apart = combined((1.0, w), (s, u), (-t, v))
    return sqrt(dot(apart, apart))
