"""A map under construction: straight legs, the bends between them, changes of the diameter."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import acos, atan2, cos, hypot, inf, isnan, nan, pi, remainder, sin, tan
from statistics import median
from typing import NamedTuple

from pirate_sm.core.geometry import DRAWING, Frame, Vector, dot

_ROUND_M = 0.04
"""A bend whose end is farther than this from its beginning is an elbow: a word is wrong by some
5 mm, and an elbow of one diameter is 60 mm long [decided]."""

LEAST_ACROSS = 0.2
"""With a smaller share of gravity across the pipe (78 deg) its roll is undefined."""


class Bore(NamedTuple):
    """What the V of a clamped part showed of the inner diameter, or several of them on average.

    Attributes:
        rear_m: Place in the leg of the part's last wheel.
        front_m: Place of its first wheel.
        diameter_m: The inner diameter.
    """

    rear_m: float
    front_m: float
    diameter_m: float

    @property
    def middle_m(self) -> float:
        """Return the place in the leg of the middle of both."""
        return (self.rear_m + self.front_m) / 2


@dataclass
class Leg:
    """A straight of the pipe, with places along it that count from an origin of its own.

    Attributes:
        begins_m: Where its axis meets that of the leg behind, or where an elbow ends; infinite if
            no bend is known.
        ends_m: Where it meets that of the leg ahead, or where an elbow begins.
        rolls_rad: Roll of the held part's plane against the horizontal, as it was felt.
        pitches_rad: Pitch of the leg, as it was felt.
        bores: What clamped parts showed of its diameter.
        reached_m: The places of the last and the first wheel that were farthest apart.
    """

    begins_m: float = -inf
    ends_m: float = inf
    rolls_rad: list[float] = field(default_factory=list)
    pitches_rad: list[float] = field(default_factory=list)
    bores: list[Bore] = field(default_factory=list)
    reached_m: tuple[float, float] = (inf, -inf)

    def reach(self, *places_m: float) -> None:
        """Take note that wheels were at these places."""
        low, high = self.reached_m
        self.reached_m = min(low, *places_m), max(high, *places_m)

    @property
    def from_m(self) -> float:
        """Return where it begins: at a bend, or where the last wheel was seen first."""
        return self.reached_m[0] if self.begins_m == -inf else self.begins_m

    @property
    def to_m(self) -> float:
        """Return where it ends: at a bend, or where the first wheel was seen last."""
        return self.reached_m[1] if self.ends_m == inf else self.ends_m


@dataclass
class MappedBend:
    """A bend between two legs.

    Attributes:
        angle_rad: By how much it turns, positive.
        roll_rad: Towards where, about the direction of travel, in the frame that is carried along
            without twist.
        kind: The kind that a word announced; empty without one.
        extent_m: How far its end is from its beginning along the pipe, both as words count: where
            the axes would meet in a mitre that takes as much wall. NaN if no word told; 0 for a
            corner.
        radius_m: Radius of an elbow's axis; 0 for a corner.
        felt: Whether its angle is from gravity.
    """

    angle_rad: float
    roll_rad: float
    kind: str = ""
    extent_m: float = nan
    radius_m: float = 0.0
    felt: bool = False

    @property
    def is_round(self) -> bool:
        """Return whether words say that it is an elbow."""
        return self.extent_m > _ROUND_M

    def wall_m(self, diameter_m: float) -> float:
        """Return how far an elbow begins before the place from which words count, m."""
        return diameter_m / 2 * tan(min(self.angle_rad / 2, pi / 4))

    def arc_m(self, diameter_m: float) -> float:
        """Return the length of an elbow's axis."""
        return self.extent_m + 2 * self.wall_m(diameter_m)


@dataclass
class Map:
    """The legs and bends that a robot has driven through.

    Attributes:
        legs: The legs in the order of the pipe; there is a bend between neighbours.
        bends: The bends.
        start: Index of the leg in which the robot began, and the place of its first wheel then.
        pitch_rad: Pitch of the leg in which it began; NaN if it was never felt.
        roll_rad: Roll of the robot's plane against the horizontal there.
        notes: What could not be mapped, in sentences.
        seen: What an operator has said of places, in the order of the run.
    """

    legs: list[Leg] = field(default_factory=lambda: [Leg()])
    bends: list[MappedBend] = field(default_factory=list)
    start: tuple[int, float] = (0, 0.0)
    pitch_rad: float = nan
    roll_rad: float = nan
    notes: list[str] = field(default_factory=list)
    seen: list[str] = field(default_factory=list)

    @property
    def up(self) -> Vector:
        """Return the unit vector against gravity in the frame of the robot where it began."""
        pitch = 0.0 if isnan(self.pitch_rad) else self.pitch_rad
        roll = 0.0 if isnan(self.roll_rad) else self.roll_rad
        return sin(pitch), cos(pitch) * sin(roll), -cos(pitch) * cos(roll)

    def beyond(self, leg: int, leads: int, bend: MappedBend) -> tuple[int, bool]:
        """Return the leg ahead of a leg, or behind it, and whether it is new, as is the bend then.

        Args:
            leg: Index of the leg.
            leads: 1 for the leg ahead, -1 for that behind, which becomes the first if it is new.
            bend: The bend between the two, if it is new.
        """
        if 0 <= leg + leads < len(self.legs):
            return leg + leads, False
        if leads > 0:
            self.legs.append(Leg(begins_m=0.0))
            self.bends.append(bend)
            return leg + 1, True
        self.legs.insert(0, Leg(ends_m=0.0))
        self.bends.insert(0, bend)
        self.start = (self.start[0] + 1, self.start[1])
        return 0, True

    def frame(self, leg: int) -> Frame:
        """Return the frame of a leg; that of the leg in which the robot began is the drawing's."""
        frame = DRAWING
        for bend in self.bends[self.start[0] : leg]:
            frame = frame.bent(frame.towards(bend.roll_rad), bend.angle_rad)
        for bend in reversed(self.bends[leg : self.start[0]]):
            frame = frame.bent(frame.towards(bend.roll_rad), -bend.angle_rad)
        return frame

    def roll_of(self, leg: int) -> float:
        """Return the roll of a leg's frame against the horizontal, rad; NaN in an upright leg."""
        frame = self.frame(leg)
        side, up = dot(frame.side, self.up), -dot(frame.normal, self.up)
        return atan2(side, up) if hypot(side, up) > LEAST_ACROSS else nan


def middle(values: list[float]) -> float:
    """Return the median; NaN of nothing."""
    return median(values) if values else nan


# --- diameters -----------------------------------------------------------------------------------


_BIN_M = 0.01
"""Diameters are averaged over this distance [decided]."""

_STRETCH_BINS = 4
"""This number of consecutive averages makes a stretch of one diameter [decided]."""

_PLATEAU_BINS = 7
"""A plain pipe shows its diameter over this distance: half a V is shorter, and while a step is
between two of its wheels a V shows a wrong diameter [decided]."""

_EVEN = 0.01
"""They differ by less than this share [decided]."""

STEP = 0.06
"""The least share by which diameters of plain pipes differ. A robot that lies slantwise in a round
pipe shows up to 5 % less; pipes of 125, 110 and 100 mm differ by 9 % and more [decided]."""


class Narrowing(NamedTuple):
    """A change of the diameter.

    Attributes:
        middle_m: Place in the leg of its middle; a V does not show how long it is.
        diameter_m: The inner diameter behind it.
    """

    middle_m: float
    diameter_m: float


def diameter_of(bores: Sequence[Bore]) -> float | None:
    """Return the first inner diameter along a leg, m; None if it was never shown."""
    plateaus = _plateaus(bores)
    if plateaus:
        return median(each.diameter_m for each in plateaus[0])
    return median(each.diameter_m for each in bores) if bores else None


def narrowings(bores: Sequence[Bore]) -> Iterator[Narrowing]:
    """Yield the changes of the diameter along a leg, in order.

    A V in the middle of a change shows the mean of the two diameters.
    """
    bins = list(_bins(bores))
    for before, after in pairwise(_plateaus(bores)):
        old_m, new_m = (median(each.diameter_m for each in it) for it in (before, after))
        between = bins[bins.index(before[0]) : bins.index(after[-1]) + 1]
        for one, other in pairwise(between):
            shares = [(it.diameter_m - old_m) / (new_m - old_m) for it in (one, other)]
            if shares[0] < 0.5 <= shares[1]:
                more = (0.5 - shares[0]) / (shares[1] - shares[0])
                yield Narrowing(one.middle_m + more * (other.middle_m - one.middle_m), new_m)
                break


def _plateaus(bores: Sequence[Bore]) -> list[list[Bore]]:
    """Return the stretches of one diameter, in order; neighbours differ by more than noise."""
    found: list[list[Bore]] = []
    part: list[Bore] = []
    for each in (*_bins(bores), None):
        known = median([it.diameter_m for it in part]) if part else 0.0
        if each is not None and abs(each.diameter_m - known) <= _EVEN * known:
            part.append(each)
            continue
        if len(part) >= _STRETCH_BINS:
            _add(found, part)
        part = [each] if each is not None else []
    return [stretch for stretch in found if len(stretch) >= _PLATEAU_BINS]


def _add(found: list[list[Bore]], part: list[Bore]) -> None:
    """Add a stretch, or join it to the last one if it has the same diameter."""
    own = median(each.diameter_m for each in part)
    last = median(each.diameter_m for each in found[-1]) if found else 0.0
    if found and abs(own - last) <= STEP * last:
        found[-1] += part
    else:
        found.append(part)


def _bins(bores: Sequence[Bore]) -> Iterator[Bore]:
    """Yield what was shown in each piece of the way."""
    pieces: dict[int, list[Bore]] = defaultdict(list)
    for each in bores:
        pieces[round((each.rear_m + each.front_m) / 2 / _BIN_M)].append(each)
    for _, group in sorted(pieces.items()):
        yield Bore(*(median(values) for values in zip(*group, strict=True)))


# --- bends between known legs --------------------------------------------------------------------


_UPRIGHT = 0.9
"""The least share of gravity in the plane of a bend whose angle pitch shows (25 deg) [decided]."""


def feel_angles(made: Map) -> None:
    """Take the angles of bends in an upright plane from the pitches of their legs."""
    first = made.start[0]
    for number in (*range(first, len(made.bends)), *range(first - 1, -1, -1)):
        near, far = (number, number + 1) if number >= first else (number + 1, number)
        bend, frame = made.bends[number], made.frame(near)
        along = dot(frame.ahead, made.up)
        towards = (far - near) * dot(frame.towards(bend.roll_rad), made.up)
        share, pitch_rad = hypot(along, towards), middle(made.legs[far].pitches_rad)
        if isnan(made.pitch_rad) or isnan(pitch_rad) or share < _UPRIGHT:
            continue
        off_rad = acos(max(-1.0, min(1.0, sin(pitch_rad) / share)))
        both = (abs(remainder(atan2(towards, along) + it, 2 * pi)) for it in (off_rad, -off_rad))
        bend.angle_rad = min(both, key=lambda angle: abs(angle - bend.angle_rad))
        bend.felt = True


def round_elbows(made: Map) -> None:
    """Find the radii of elbows, and let the legs next to them end where they begin."""
    for number, bend in enumerate(made.bends):
        behind, ahead = made.legs[number : number + 2]
        diameter_m = diameter_of(ahead.bores) or diameter_of(behind.bores)
        if bend.is_round and diameter_m is not None:
            bend.radius_m = bend.arc_m(diameter_m) / bend.angle_rad
            behind.ends_m -= bend.wall_m(diameter_m)
            ahead.begins_m += bend.wall_m(diameter_m)
