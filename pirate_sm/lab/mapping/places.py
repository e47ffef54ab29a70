"""Where the parts of a robot are in the legs of a map, by their wheels, joints and gravity."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import isnan, nan, pi, radians, remainder
from typing import NamedTuple

from pirate_sm.core.geometry import Frame, between, dot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import WHOLE, BodySpec, RobotLook
from pirate_sm.lab.mapping.axes import axis_at, axis_of, wheel_at
from pirate_sm.lab.mapping.bend_angles import angle_between, outermost
from pirate_sm.lab.mapping.legs import Map, middle
from pirate_sm.robot.detectors.odometry_detector import Odometer

# --- spots ---------------------------------------------------------------------------------------


class Anchor(NamedTuple):
    """A part whose place is known.

    Attributes:
        part: Its index.
        axis: The axis of its leg, at the middle of the wheels that show it.
        along_m: Place of that in the leg.
        whole: Whether all its wheels show the axis, or its outermost link alone.
    """

    part: int
    axis: Frame
    along_m: float
    whole: bool


class Spot(NamedTuple):
    """Where a held part is.

    Attributes:
        leg: Index of its leg.
        along_m: Place in the leg of the middle of the wheels.
        wheels: These wheels: the part's, or the two of its outermost link.
    """

    leg: int
    along_m: float
    wheels: tuple[int, ...]


@dataclass
class Approach:
    """A joint ahead, by the words that announced it.

    Attributes:
        leg: Index of the leg behind it.
        leads: The direction of travel.
        begins_m: Where it begins, in that leg.
        ends_m: Where it ends, had the leg gone on round it; NaN before a word says so.
    """

    leg: int
    leads: int
    begins_m: float
    ends_m: float = nan


@dataclass
class BendPassage:
    """A bend that the robot is in.

    Attributes:
        bend: Index of the bend.
        leads: 1 if the front part has gone first, -1 if the rear part has.
        first: The part that has gone first.
        anchor: The part that lay along the leg behind then; it comes last.
        numbers: The signals then.
        new: Whether the bend was not known before.
        placed: Whether the part that comes last has given the place of the other one.
        passed: Whether a word says that the whole robot is behind it.
    """

    bend: int
    leads: int
    first: int
    anchor: Anchor
    numbers: tuple[float, ...]
    new: bool
    placed: bool = False
    passed: bool = False


# --- ways travelled ------------------------------------------------------------------------------
# A driven wheel that slips turns farther than the robot moves. Parts along one leg move alike, but
# for what the joints between them stretch, as at a reducer. So of two held parts that do not agree
# the one counts that has rolled less; within a part the median of its wheels counts. In a bend the
# wheels on its outer side roll farther than the pipe's axis is long, and those on its inner side
# less: there the mean of the two sides counts.


_PIECE_S = 5.0
"""Parts are compared over this time, or until they disagree [decided]."""

_AGREEING_M = 0.005
"""Parts that have rolled alike up to this have not slipped, and their mean counts: always to take
the lesser would add up noise [decided]."""


class Way:
    """Counts the way of each part, from zero.

    Args:
        robot: The robot.
    """

    def __init__(self, robot: RobotSpec) -> None:
        body = robot.body
        parts = range(len(body.parts))
        wheels = [body.wheels_of(part) for part in parts]
        self._straight = [_Rolled(robot, [own]) for own in wheels]
        self._bent = [
            _Rolled(robot, [[w for w in own if body.sides[w] == side] for side in (1, -1)])
            for own in wheels
        ]
        self._own_m = [0.0 for _ in parts]
        self._begun_m = [0.0 for _ in parts]
        self._counted_m = [0.0 for _ in parts]
        self._held: frozenset[int] = frozenset()
        self._places_m: dict[int, float] = {}
        self._begun_s = 0.0

    def until(
        self,
        look: RobotLook,
        held: Collection[int],
        places_m: Mapping[int, float],
        bent: Collection[int] = (),
    ) -> list[float]:
        """Return the way of each part until this look, m; backward counts negative.

        Args:
            look: What is known of the robot.
            held: The parts that hold it; empty if it lies loose.
            places_m: Where parts along one leg are against each other, by the joints.
            bent: The parts that are in a bend.
        """
        for part, (straight, sides) in enumerate(zip(self._straight, self._bent, strict=True)):
            along_m, around_m = straight.since_last(look), sides.since_last(look)
            self._own_m[part] += around_m if part in bent else along_m
        counted_m, agreed = self._until_now(places_m)
        now = frozenset(held)
        anew = now != self._held or places_m.keys() != self._places_m.keys() or not agreed
        if anew or look.at_s - self._begun_s >= _PIECE_S:
            self._begun_m, self._begun_s, self._held = list(self._own_m), look.at_s, now
            self._counted_m, self._places_m = counted_m, dict(places_m)
        return counted_m

    def _until_now(self, places_m: Mapping[int, float]) -> tuple[list[float], bool]:
        """Return the way of each part, with this piece, and whether the parts agree on it."""
        parts = range(len(self._own_m))
        stretched_m = [0.0 for _ in parts]
        if places_m.keys() == self._places_m.keys():
            for part, place_m in places_m.items():
                stretched_m[part] = place_m - self._places_m[part]
        moved_m = [
            self._own_m[part] - self._begun_m[part] - stretched_m[part]
            for part in self._held or parts
        ]
        agreed = max(moved_m) - min(moved_m) <= _AGREEING_M
        alike_m = sum(moved_m) / len(moved_m) if agreed else min(moved_m, key=abs)
        return [self._counted_m[part] + alike_m + stretched_m[part] for part in parts], agreed


class _Rolled:
    """What groups of wheels have rolled: the mean of the groups."""

    def __init__(self, robot: RobotSpec, groups: Collection[Collection[int]]) -> None:
        self._groups = [(Odometer(robot), tuple(group)) for group in groups if group]
        self._last_m = 0.0

    def since_last(self, look: RobotLook) -> float:
        """Return what they have rolled since it was asked last, m."""
        counts = [look.travelled(each.look, wheels) for each, wheels in self._groups]
        before_m, self._last_m = self._last_m, sum(counts) / len(counts)
        return self._last_m - before_m


# --- what the joints show ------------------------------------------------------------------------


_AGREEING = 0.05
"""A V that shows the diameter of its leg up to this share lies along it; one that lies slantwise in
a round pipe shows up to 5 % less [decided]."""

_LAST = 9
"""This number of the last diameters of a part counts."""

_BORE_EVERY_M = 0.02
"""The diameter that a part shows counts again after this distance [decided]."""


class Shape:
    """Knows the diameters that the parts have lately shown in a straight.

    Args:
        body: The robot's chain.
    """

    def __init__(self, body: BodySpec) -> None:
        self._body = body
        self._bores: dict[int, deque[float]] = {}
        self._bored_m: dict[int, float] = {}

    def shown(self, look: RobotLook, part: int) -> float:
        """Return the diameter that a part shows now, m; NaN if it is unknown."""
        index = self._body.parts[part].diameter
        return look.numbers[index] if index >= 0 else nan

    def bore(self, part: int) -> float:
        """Return the diameter that a part, or any other, has lately shown in a straight, m."""
        shown = self._bores.get(part) or next(iter(self._bores.values()), ())
        return middle(list(shown))

    def note_bore(self, look: RobotLook, part: int, way_m: float, *, parallel: bool) -> None:
        """Take note of what a part shows, once it is farther.

        Args:
            look: What is known of the robot.
            part: The part.
            way_m: How far it has travelled.
            parallel: Whether parts lie along one axis; the first diameter counts without that.
        """
        farther = part not in self._bored_m or abs(way_m - self._bored_m[part]) >= _BORE_EVERY_M
        if farther and (parallel or not self._bores):
            self._bored_m[part] = way_m
            self._bores.setdefault(part, deque(maxlen=_LAST)).append(self.shown(look, part))

    def start_again(self, look: RobotLook, part: int) -> None:
        """Take what a part shows for the diameter of a new leg."""
        self._bores[part] = deque([self.shown(look, part)], maxlen=_LAST)

    def lies(self, look: RobotLook, part: int, like: int | None = None) -> bool:
        """Return whether the V of a part shows the diameter of its leg, or of another part's."""
        shown, known = self.shown(look, part), self.bore(part if like is None else like)
        return isnan(known) or abs(shown - known) <= _AGREEING * known

    def whole(self, look: RobotLook) -> Frame | None:
        """Return the axis of the whole robot; None if a joint is unknown."""
        wheels = self._body.wheels_of(WHOLE)
        return axis_of(self._body, look.numbers, wheels, 2 * self._body.wheel_radius_m)

    def frame(self, look: RobotLook, part: int, spot: Spot) -> Frame | None:
        """Return the axis at the wheels of a spot."""
        if part == WHOLE:
            return self.whole(look)
        return axis_of(self._body, look.numbers, spot.wheels, self.bore(part))

    def ahead_of(self, look: RobotLook, wheel: int, frame: Frame) -> float:
        """Return how far a wheel is ahead of the origin of a frame, m."""
        place = wheel_at(self._body, look.numbers, wheel)
        return dot(between(frame.origin, place), frame.ahead)


# --- places --------------------------------------------------------------------------------------


ALONG_RAD = radians(10)
"""Two parts whose axes differ by less are in one leg [decided]."""


class PartPlaces:
    """Follows the parts whose places are known.

    Args:
        robot: The robot.
        shape: What its joints show.

    Attributes:
        spots: Where parts are, by their index.
        ways_m: How far each part has travelled.
    """

    def __init__(self, robot: RobotSpec, shape: Shape) -> None:
        self.spots: dict[int, Spot] = {}
        self.ways_m = [0.0 for _ in robot.body.parts]
        self._body, self._shape, self._way = robot.body, shape, Way(robot)
        self._links: dict[int, tuple[tuple[int, ...], float]] = {}

    def move(self, look: RobotLook) -> None:
        """Move what is known by what the odometer has counted since the last look."""
        parts = [part for part in self.spots if part != WHOLE]
        bent = [part for part in parts if not self._shape.lies(look, part)]
        before_m, self.ways_m = self.ways_m, self._way.until(look, parts, self._apart(look), bent)
        moved_m = [now - then for now, then in zip(self.ways_m, before_m, strict=True)]
        for part, spot in self.spots.items():
            way_m = moved_m[part] if part != WHOLE else sum(moved_m) / len(moved_m)
            self.spots[part] = spot._replace(along_m=spot.along_m + way_m)

    def shift(self, leg: int, by_m: float) -> None:
        """Correct the places of parts in a leg."""
        for part, spot in self.spots.items():
            if spot.leg == leg:
                self.spots[part] = spot._replace(along_m=spot.along_m + by_m)

    def laid(self, look: RobotLook, part: int, spot: Spot) -> Spot:
        """Return the place of the whole robot from that of a part."""
        frame, whole = self._shape.frame(look, part, spot), self._shape.whole(look)
        away_m = 0.0
        if frame is not None and whole is not None:
            away_m = dot(between(frame.origin, whole.origin), frame.ahead)
        return Spot(spot.leg, spot.along_m + away_m, self._body.wheels_of(WHOLE))

    def anchor(self, look: RobotLook) -> Anchor | None:
        """Return a part that lies along its leg, or whose outermost link does; None without one."""
        for part, spot in self.spots.items():
            if part == WHOLE or not self._shape.lies(look, part):
                continue
            frame = axis_at(self._body, look.numbers, part)
            if frame is None:
                continue
            own = self._body.wheels_of(part)
            if spot.wheels != own:  # from now on the whole V counts
                link = self._shape.frame(look, part, spot)
                away_m = dot(between(link.origin, frame.origin), frame.ahead) if link else 0.0
                self.spots[part] = Spot(spot.leg, spot.along_m + away_m, own)
            wheels = outermost(self._body, part, 1 if own[0] == 0 else -1)
            link = axis_of(self._body, look.numbers, wheels, self._shape.bore(part))
            if link is not None:
                away_m = dot(between(frame.origin, link.origin), frame.ahead)
                self._links[part] = wheels, away_m
            return Anchor(part, frame, self.spots[part].along_m, whole=True)
        return self._pulled(look)

    def _pulled(self, look: RobotLook) -> Anchor | None:
        """Return a part that another one has pulled out of shape, by its outermost link."""
        for part, spot in self.spots.items():
            if part in self._links and spot.wheels == self._body.wheels_of(part):
                wheels, away_m = self._links[part]
                frame = axis_of(self._body, look.numbers, wheels, self._shape.bore(part))
                if frame is not None:
                    return Anchor(part, frame, spot.along_m + away_m, whole=False)
        return None

    def _apart(self, look: RobotLook) -> dict[int, float]:
        """Return where parts along one leg are against each other, m."""
        axes = {
            part: axis
            for part in self.spots
            if part != WHOLE and (axis := axis_at(self._body, look.numbers, part)) is not None
        }
        if len(axes) < 2 or len({self.spots[part].leg for part in axes}) > 1:
            return {}
        one, *others = axes.values()
        if any(angle_between(one, other) > ALONG_RAD for other in others):
            return {}
        return {part: dot(between(one.origin, it.origin), one.ahead) for part, it in axes.items()}


# --- rolls and slopes ----------------------------------------------------------------------------


_STEEP_RAD = radians(60)
"""In a steeper leg a robot's roll is not taken from gravity [decided]."""

_FELT = 9
"""This number of the last rolls counts."""

_FELT_EVERY_S = 0.2


class Rolls:
    """Feels gravity.

    Args:
        made: The map, whose legs take note of it.
        body: The robot's chain.
    """

    def __init__(self, made: Map, body: BodySpec) -> None:
        self._map, self._body = made, body
        self._rho_rad = 0.0
        self._felt_s = -1.0

    def feel(self, look: RobotLook, spots: Mapping[int, Spot]) -> None:
        """Take note of gravity in the leg of the part that feels it."""
        around, spot, made = look.around, spots.get(look.part), self._map
        if spot is None or look.at_s < self._felt_s + _FELT_EVERY_S or isnan(around.pitch_rad):
            return
        self._felt_s = look.at_s
        leg = made.legs[spot.leg]
        leg.pitches_rad.append(around.pitch_rad)
        roll_rad = around.roll_rad - self._twist(look, look.part)
        if not isnan(roll_rad) and abs(around.pitch_rad) < _STEEP_RAD:
            leg.rolls_rad.append(roll_rad)
        if spot.leg == made.start[0] and not made.bends:
            made.pitch_rad = middle(leg.pitches_rad)
            if len(leg.rolls_rad) <= _FELT:
                made.roll_rad = middle(leg.rolls_rad)

    def of_part(self, look: RobotLook, part: int, leg: int) -> float:
        """Return the roll of a part's plane in a leg against the frame carried along, rad."""
        felt_rad, frame_rad = self._map.legs[leg].rolls_rad[-_FELT:], self._map.roll_of(leg)
        if felt_rad and not isnan(frame_rad):
            self._rho_rad = remainder(middle(felt_rad) - frame_rad, 2 * pi)
        return self._rho_rad + self._twist(look, part)

    def _twist(self, look: RobotLook, part: int) -> float:
        """Return the roll of a part's plane against that of the rear half, rad."""
        roll, ahead = (
            self._body.roll,
            part >= 0 and (self._body.parts[part].wheels[0] <= self._body.roll_link),
        )
        return look.numbers[roll] if roll >= 0 and ahead else 0.0
