"""Places the runs of a network in space, and finds those that run into each other.

The first run begins at the origin of the drawing. Each other run begins or ends at a junction whose
place is known by then; a run that is placed by both its ends shows whether a loop closes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, pairwise
from math import asin, ceil, degrees, dist, pi, sqrt
from typing import NamedTuple

from pirate_sm.core._geometry.network import (
    BRANCH,
    IN,
    ON,
    Arc,
    Elbow,
    Mitre,
    Network,
    NetworkRun,
    Piece,
    Reducer,
    Straight,
    Tee,
    port_of,
)
from pirate_sm.core._geometry.space import DRAWING, Frame, Vector, between, combined, dot

MOST_GAP_M = 0.005
MOST_ANGLE_RAD = pi / 180
"""How far the two ends of a closed loop may miss each other."""


class Misfit(NamedTuple):
    """Why a run does not fit into its network.

    Attributes:
        run: Name of the run.
        begins: Whether its beginning does not fit, else its end.
        message: What is wrong.
    """

    run: str
    begins: bool
    message: str


@dataclass(frozen=True)
class Placement:
    """The runs of a network in space.

    Attributes:
        runs: By name the pieces of each run, with arc lengths of their own; a run that nothing
            connects with the first is missing.
        tees: Frame of each tee: where the axes intersect, ahead from its port ``NAME`` to
            ``NAME.on``, side towards its branch.
        misfits: What does not fit.
    """

    runs: Mapping[str, tuple[Piece, ...]]
    tees: Mapping[str, Frame]
    misfits: tuple[Misfit, ...]


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

    def after(self, bend: Mitre | Elbow) -> _Heading:
        if not bend.roll_rad:
            return self._replace(turned_rad=self.turned_rad + bend.angle_rad)
        frame = self.frame.rolled(bend.roll_rad).turned(bend.angle_rad)
        return _Heading(frame.rolled(-bend.roll_rad))


class _Door(NamedTuple):
    """Where a run leaves a junction: the heading there, out of it, and the place."""

    heading: _Heading
    origin: Vector

    @property
    def frame(self) -> Frame:
        return self.heading.frame._replace(origin=self.origin)

    @classmethod
    def at(cls, frame: Frame) -> _Door:
        return cls(_Heading(frame), frame.origin)


def place(network: Network) -> Placement:
    """Return where the runs of a network are."""
    placer = _Placer(network)
    placer.place(next(iter(network.runs)), _Door(_Heading(), DRAWING.origin), from_end=False)
    while any(placer.connect(run) for run in network.runs):
        pass
    lost = [
        Misfit(name, True, f"nothing connects this with the run '{next(iter(network.runs))}'")
        for name in network.runs
        if name not in placer.runs
    ]
    return Placement(placer.runs, placer.tees, (*placer.misfits, *lost))


@dataclass
class _Placer:
    """Places one run after the other."""

    network: Network
    runs: dict[str, tuple[Piece, ...]] = field(default_factory=dict)
    tees: dict[str, Frame] = field(default_factory=dict)
    misfits: list[Misfit] = field(default_factory=list)
    _doors: dict[str, _Door] = field(default_factory=dict)
    _taken: set[str] = field(default_factory=set)

    def connect(self, name: str) -> bool:
        """Place a run at a junction that is known; return whether it did."""
        run = self.network.runs[name]
        for at, from_end in ((run.begins, False), (run.ends, True)):
            if name not in self.runs and at in self._doors:
                self.place(name, self._doors[at], from_end=from_end)
                return True
        return False

    def place(self, name: str, door: _Door, *, from_end: bool) -> None:
        """Place a run that leaves a junction by this door, with its end if ``from_end``."""
        run = self.network.runs[name]
        pieces, last = _laid(name, run, _Door(_Heading(), DRAWING.origin) if from_end else door)
        if from_end:
            ends = door.frame.reversed()
            pieces = tuple(piece.carried(last.frame, ends) for piece in pieces)
            last = _Door.at(ends)
        self.runs[name] = pieces
        first = door if not from_end else _Door.at(pieces[0].frame)
        self._reach(name, run.begins, _Door.at(first.frame.reversed()), begins=True)
        self._reach(name, run.ends, last, begins=False)

    def _reach(self, name: str, at: str, out: _Door, *, begins: bool) -> None:
        """Take note of a junction that a run reaches; its heading is that out of the run."""
        junction, port = port_of(at)
        tee = self.network.tees.get(junction)
        if at in self._taken:
            other = "another run is there already"
            self.misfits.append(Misfit(name, begins, f"'{at}' is taken: {other}"))
        elif at in self._doors:
            self._compare(name, self._doors[at].frame, out.frame.reversed(), begins=begins)
        elif tee is None:
            self._doors[at] = out
            return
        else:
            self._open(junction, tee, port, out)
        self._taken.add(at)

    def _compare(self, name: str, known: Frame, found: Frame, *, begins: bool) -> None:
        """Report a run that misses its junction."""
        gap = dist(known.origin, found.origin)
        angle = _angle(known.ahead, found.ahead)
        if gap > MOST_GAP_M:
            message = f"this misses its junction by {gap * 1000:.0f} mm: seen along the first run "
            message += f"it lies {_way(known.origin, found.origin)}"
            self.misfits.append(Misfit(name, begins, message))
        elif angle > MOST_ANGLE_RAD:
            message = f"this meets its junction {degrees(angle):.0f} deg askew"
            self.misfits.append(Misfit(name, begins, message))

    def _open(self, name: str, tee: Tee, port: str, out: _Door) -> None:
        """Fix a tee by the first run that reaches it, and open its other ports."""
        roll = tee.roll_rad
        frame = out.frame.rolled(roll)
        if port == ON:
            frame = out.frame.reversed().rolled(roll)
        elif port == BRANCH:
            frame = out.frame.reversed().rolled(roll).turned(-pi / 2)
        self.tees[name] = frame
        onward = out if port == IN else _Door.at(frame.rolled(-roll))
        doors = {
            IN: _Door.at(onward.frame.reversed()),
            ON: onward,
            BRANCH: _Door.at(frame.turned(pi / 2).rolled(-roll)),
        }
        for other, door in doors.items():
            if other != port:
                self._doors[f"{name}.{other}" if other else name] = door


def _laid(name: str, run: NetworkRun, door: _Door) -> tuple[tuple[Piece, ...], _Door]:
    """Return the pieces of a run that begins at a door, and the door at its end."""
    heading, origin = door
    found: list[Piece] = []
    arc_m, length_m, taken_m, first = 0.0, 0.0, 0.0, 0
    around = (*zip(run.segments, run.diameters_m, strict=False), (None, run.diameters_m[-1]))
    for number, (segment, diameter_m) in enumerate(around):
        if isinstance(segment, Straight):
            length_m += segment.length_m
            continue
        mitre = segment if isinstance(segment, Mitre) else None
        after = mitre.taken_m(diameter_m) if mitre else 0.0
        frame, taken = heading.frame._replace(origin=origin), (taken_m, after)
        if length_m > 0.0:
            piece = Piece(
                frame, length_m, arc_m, diameter_m, taken, mitre, name, first, run.section
            )
            found.append(piece)
            origin, arc_m = frame.point(length_m), arc_m + length_m
        length_m, taken_m, first = 0.0, after, number + 1
        if isinstance(segment, Elbow | Reducer):
            frame = frame._replace(origin=origin)
            piece = _fitting(segment, frame, arc_m, diameter_m, name, number)
            found.append(piece._replace(section=run.section))
            origin, arc_m = piece.frame_at(piece.ends_m).origin, piece.ends_m
        if isinstance(segment, Mitre | Elbow):
            heading = heading.after(segment)
    return tuple(found), _Door(heading, origin)


def _fitting(
    segment: Elbow | Reducer, frame: Frame, arc_m: float, diameter_m: float, run: str, number: int
) -> Piece:
    """Return the piece of a fitting that has a length of its own."""
    at = (frame, segment.length_m, arc_m, diameter_m, (0.0, 0.0), None, run, number)
    if isinstance(segment, Reducer):
        return Piece(*at, narrowed_m=segment.to_m)
    towards = frame.towards(segment.roll_rad if segment.angle_rad > 0 else segment.roll_rad + pi)
    return Piece(*at, arc=Arc(segment.radius_m, abs(segment.angle_rad), towards))


def _way(known: Vector, found: Vector) -> str:
    """Return by how much and to which sides a point is off another one, in the drawing."""
    apart_mm = [round(1000 * (at - wanted)) for at, wanted in zip(found, known, strict=True)]
    ways = (("ahead", "back"), ("to side A", "to side B"), ("down", "up"))
    off = [
        f"{abs(each)} mm too far {way[each < 0]}"
        for each, way in zip(apart_mm, ways, strict=True)
        if each
    ]
    return ", ".join(off)


def _angle(one: Vector, other: Vector) -> float:
    """Return the angle between two unit vectors, rad."""
    return 2.0 * asin(min(dist(one, other) / 2.0, 1.0))


# --- pipes that run into each other -----------------------------------------------------------


_CHORD_RAD = pi / 12
"""An arc is looked at as chords of this angle."""

_TOUCH_M = 1e-3
"""Pipes that overlap by less only touch."""

_NO_LENGTH_M = 1e-9
"""What rounding leaves of a piece that is as long as it is wide has no direction."""


def crossings(network: Network, placement: Placement) -> Iterator[tuple[Piece, Piece]]:
    """Yield the pairs of pieces whose pipes run into each other.

    Neighbours meet at their fitting or junction and are not compared. Next to its fittings a piece
    is shortened by its radius, since pipes that follow each other round a short bend touch there.
    """
    pieces = [piece for run in placement.runs.values() for piece in run]
    long = [(piece, axis) for piece in pieces if (axis := _axis(piece))]
    neighbours = _neighbours(network, placement)
    for pair in meeting([axis for _, axis in long], [_widest(piece) / 2 for piece, _ in long]):
        (one, axis), (other, near) = (long[number] for number in pair)
        least = (_widest(one) + _widest(other)) / 2 - _TOUCH_M
        if frozenset((id(one), id(other))) not in neighbours and _closer(axis, near, least):
            yield one, other


def meeting(
    shapes: Sequence[Sequence[Sequence[float]]], around: Sequence[float]
) -> list[tuple[int, int]]:
    """Return the pairs of shapes whose boxes meet, by their numbers, in order.

    They are swept along the axis along which they reach farthest, so that only those are compared
    that lie side by side (Ericson, Real-Time Collision Detection, section 7.5.1).

    Args:
        shapes: The points of each shape.
        around: By how much its box is larger than these on all sides.
    """
    boxes = [
        [(min(along) - more, max(along) + more) for along in zip(*points, strict=True)]
        for points, more in zip(shapes, around, strict=True)
    ]
    axes = list(zip(*boxes, strict=True))
    reach = [max(high for _, high in each) - min(low for low, _ in each) for each in axes]
    axis = reach.index(max(reach)) if reach else 0
    beside, found = list[int](), list[tuple[int, int]]()
    for number in sorted(range(len(boxes)), key=lambda each: boxes[each][axis]):
        own = boxes[number]
        beside = [each for each in beside if boxes[each][axis][1] >= own[axis][0]]
        for other in beside:
            if all(a <= d and c <= b for (a, b), (c, d) in zip(own, boxes[other], strict=True)):
                found.append((min(number, other), max(number, other)))
        beside.append(number)
    return sorted(found)


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
    if last - first < _NO_LENGTH_M:
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
