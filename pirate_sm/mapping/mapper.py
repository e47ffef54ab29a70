"""Follows a robot through an unknown pipe: where it is, how long the legs are, how they meet.

A clamped part whose V shows the inner diameter of its leg lies along the leg: it is an anchor, and
moves by what the odometer counts. When another part clamps, the joint angles say where it stands.

- Along the anchor's axis: in the same leg.
- Otherwise it is the first to reach into another leg. Its outermost link stands from wall to wall
  there and gives the axis of the new leg: both axes give the bend's angle, its plane and its place.
- When the part that comes last clamps, the other is the anchor already, and its place was only
  estimated: it was not pressed between the walls then. The outermost wheel of the last part still
  touches its wall in the leg behind, which gives the anchor's place in the new leg anew.

Neglected: slip of all wheels of a part at once; motion of an anchor that the odometer does not see.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from math import acos, cos, inf, isnan, nan, pi, radians, remainder, sin
from typing import NamedTuple

from pirate_sm.detectors.odometer import Odometer
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.body_spec import WHOLE
from pirate_sm.engine.sensing.part_axes import (
    axis_at,
    axis_of,
    meeting,
    plane_of,
    wheel_at,
)
from pirate_sm.geometry.space import Frame, Vector, between, combined, dot, scaled
from pirate_sm.mapping.legs import Bend, Bore, Leg, Map, middle
from pirate_sm.mapping.listening import Look

_AGREEING = 0.03
"""A V that shows the diameter of its leg up to this share lies along it [decided]."""

_ALONG_RAD = radians(10)
"""Two parts whose axes differ by less are in one leg [decided]."""

_PARALLEL_RAD = radians(2)
"""Two parts whose axes differ by less show the diameters of plain pipes [decided]."""

_BEND_RAD = radians(20)
"""The least angle of a bend that is told from a slanting part [decided]."""

_STEEP_RAD = radians(60)
"""In a steeper leg a robot's roll is not taken from gravity [decided]."""

_FELT = 9
"""So many of the last rolls count, and of the last diameters of a part."""

_BORE_EVERY_M = 0.02
"""The diameter that a part shows counts again after so much of the way [decided]."""

_MOST_MOVED_M = 0.05
"""By more than this the anchor's place in a new leg is not corrected [decided]."""


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
class _Passage:
    """A bend that the robot is in.

    Attributes:
        bend: Index of the bend.
        leads: 1 if the front part has gone first, -1 if the rear part has.
        last: The part that comes last.
        placed: Whether that part has given the place of the other one.
    """

    bend: int
    leads: int
    last: int
    placed: bool = False


class Mapper:
    """Makes a map of a pipe from looks at a robot that drives through it.

    Args:
        robot: The robot.

    Attributes:
        robot: The robot.
        map: The map so far.
        lost: Whether nothing is known any more of where the robot is.
    """

    def __init__(self, robot: RobotSpec) -> None:
        self.map = Map()
        self.lost = False
        self.robot, self._body = robot, robot.body
        self._odometer = Odometer(robot)
        self._way_m = 0.0
        self._spots: dict[int, Spot] = {}
        self._bores: dict[int, deque[float]] = {}
        self._bored_m: dict[int, float] = {}
        self._passage: _Passage | None = None
        self._rho_rad = 0.0
        self._felt_s = -1.0
        self._announced = ""

    def look(self, look: Look) -> None:
        """Take what is known at another time into the map."""
        if self.lost:
            return
        self._announced = look.announced or self._announced
        self._move(look)
        if not self._spots:
            self._begin(look)
            return
        self._release(look)
        anchor = self._anchor(look)
        for part in sorted(look.held - self._spots.keys()):
            if anchor is not None and self._along(look, part, *anchor):
                continue
            if anchor is not None and not look.driven:
                self._across(look, part, *anchor)
        self._feel(look)
        self._measure(look)

    # --- where the robot is -------------------------------------------------------------------

    def _move(self, look: Look) -> None:
        """Move what is known by what the odometer has counted since the last look."""
        anchor = min(self._spots, default=WHOLE)
        counted_m = look.travelled(self._odometer, self._body.wheels_of(anchor))
        moved_m, self._way_m = counted_m - self._way_m, counted_m
        for part, spot in self._spots.items():
            self._spots[part] = spot._replace(along_m=spot.along_m + moved_m)

    def _begin(self, look: Look) -> None:
        """Begin once all joints are known; the middle of the robot is the origin of its leg."""
        frame = self._whole(look)
        if frame is None:
            return
        wheels = self._body.wheels_of(WHOLE)
        self._spots[WHOLE] = Spot(0, 0.0, wheels)
        places = [self._ahead_of(look, wheel, frame) for wheel in wheels]
        self.map.legs[0].reach(*places)
        self.map.start = (0, places[0])
        if look.held:
            self._release(look)

    def _release(self, look: Look) -> None:
        """Forget parts that hold no more; a robot that nothing holds lies where it was."""
        before = dict(self._spots)
        for part in self._spots.keys() - look.held:
            del self._spots[part]
        if self._spots:
            return
        known = next(iter(before.items()))
        frame = self._frame(look, *known)
        if not look.held:
            self._spots[WHOLE] = known[1] if known[0] == WHOLE else self._laid(look, *known)
        elif frame is not None and known[0] == WHOLE:
            part = min(look.held)
            axis = axis_at(self._body, look.numbers, part)
            if axis is not None:
                away_m = dot(between(frame.origin, axis.origin), axis.ahead)
                wheels = self._body.wheels_of(part)
                self._spots[part] = Spot(known[1].leg, known[1].along_m + away_m, wheels)
        else:
            self.lost = True
            self.map.notes.append(f"the robot's place was lost at {look.at_s:.1f} s")

    def _laid(self, look: Look, part: int, spot: Spot) -> Spot:
        """Return the place of the whole robot from that of a part."""
        frame, whole = self._frame(look, part, spot), self._whole(look)
        away_m = 0.0
        if frame is not None and whole is not None:
            away_m = dot(between(frame.origin, whole.origin), frame.ahead)
        return Spot(spot.leg, spot.along_m + away_m, self._body.wheels_of(WHOLE))

    def _anchor(self, look: Look) -> tuple[int, Frame] | None:
        """Return a part that lies along its leg, with its axis; None without one."""
        for part, spot in self._spots.items():
            if part == WHOLE or not self._lies(look, part):
                continue
            frame = axis_at(self._body, look.numbers, part)
            if frame is None:
                continue
            own = self._body.wheels_of(part)
            if spot.wheels != own:  # from now on the whole V counts
                link = self._frame(look, part, spot)
                away_m = dot(between(link.origin, frame.origin), frame.ahead) if link else 0.0
                self._spots[part] = Spot(spot.leg, spot.along_m + away_m, own)
            return part, frame
        return None

    def _lies(self, look: Look, part: int) -> bool:
        """Return whether the V of a part shows the diameter of its leg."""
        shown, known = self._shown(look, part), self._bore(part)
        return isnan(known) or abs(shown - known) <= _AGREEING * known

    # --- another part clamps ------------------------------------------------------------------

    def _along(self, look: Look, part: int, anchor: int, axis: Frame) -> bool:
        """Place a part in the anchor's leg if it lies along it; return whether it does."""
        own = axis_at(self._body, look.numbers, part)
        if own is None or not self._lies(look, part) or _between(own, axis) > _ALONG_RAD:
            return False
        spot = self._spots[anchor]
        away_m = dot(between(axis.origin, own.origin), axis.ahead)
        self._spots[part] = Spot(spot.leg, spot.along_m + away_m, self._body.wheels_of(part))
        if self._passage is not None and self._passage.last == part:
            self._passage = None
        return True

    def _across(self, look: Look, part: int, anchor: int, axis: Frame) -> None:
        """Place a part, or the anchor by it, if there is a bend between them."""
        passage = self._passage
        if passage is None:
            self._reach_into(look, part, anchor, axis)
        elif passage.last == part and not passage.placed:
            passage.placed = True
            self._correct(look, passage, anchor, axis)

    def _reach_into(self, look: Look, part: int, anchor: int, axis: Frame) -> None:
        """Find the bend between the anchor and a part that has gone first into another leg."""
        wheels = self._body.wheels_of(part)
        leads = 1 if wheels[0] < self._body.wheels_of(anchor)[0] else -1
        outermost = wheels[:2] if leads > 0 else wheels[-2:]
        own = axis_of(self._body, look.numbers, outermost, self._bore(part))
        if own is None or _between(own, axis) < _BEND_RAD:
            return
        spot, behind, ahead = self._spots[anchor], axis, own
        if leads < 0:
            behind, ahead = own, axis
        met = meeting(behind, ahead)
        towards = behind.roll_of(_across(ahead.ahead, behind.ahead))
        if leads < 0:
            towards = ahead.roll_of(scaled(-1.0, _across(behind.ahead, ahead.ahead)))
        rolled = self._roll_of_part(look, anchor)
        bend = Bend(met.angle_rad, remainder(towards + rolled, 2 * pi), self._announced)
        self._announced = ""
        into = self._join(spot, leads, bend, met.behind_m if leads > 0 else met.ahead_m)
        leg = self.map.legs[into]
        place_m = leg.begins_m + met.ahead_m if leads > 0 else leg.ends_m - met.behind_m
        self._spots[part] = Spot(into, place_m, tuple(outermost))
        self._passage = _Passage(into - 1 if leads > 0 else into, leads, anchor)

    def _join(self, spot: Spot, leads: int, bend: Bend, away_m: float) -> int:
        """Add a bend at a distance from the anchor, or find it; return the leg beyond it."""
        legs, at_m = self.map.legs, spot.along_m + leads * away_m
        known = spot.leg + leads
        if 0 <= known < len(legs):  # it comes back: the bend says where it is
            place_m = legs[spot.leg].ends_m if leads > 0 else legs[spot.leg].begins_m
            self._shift(spot.leg, place_m - at_m)
            return known
        if leads > 0:
            legs[spot.leg].ends_m = at_m
            legs.append(Leg(begins_m=0.0))
            self.map.bends.append(bend)
            return known
        legs[spot.leg].begins_m = at_m
        legs.insert(0, Leg(ends_m=0.0))
        self.map.bends.insert(0, bend)
        self.map.start = (self.map.start[0] + 1, self.map.start[1])
        self._spots = {n: each._replace(leg=each.leg + 1) for n, each in self._spots.items()}
        return 0

    def _shift(self, leg: int, by_m: float) -> None:
        for part, spot in self._spots.items():
            if spot.leg == leg:
                self._spots[part] = spot._replace(along_m=spot.along_m + by_m)

    def _correct(self, look: Look, passage: _Passage, anchor: int, axis: Frame) -> None:
        """Correct the anchor's place by the outermost wheel of the part that comes last."""
        bend, leads = self.map.bends[passage.bend], passage.leads
        wheels = self._body.wheels_of(passage.last)
        wheel = wheels[-1] if leads > 0 else wheels[0]
        rolled = self._roll_of_part(look, anchor)
        towards = axis.towards(bend.roll_rad - rolled)
        other = combined((cos(bend.angle_rad), axis.ahead), (-leads * sin(bend.angle_rad), towards))
        side = _cross(plane_of(self._body, look.numbers, passage.last).normal, other)
        slope = dot(axis.ahead, side)
        if abs(slope) < sin(_BEND_RAD):
            return
        place = between(axis.origin, wheel_at(self._body, look.numbers, wheel))
        aside_m = self._body.sides[wheel] * (self._bore(passage.last) / 2 - self._radius_m)
        away_m = leads * (aside_m - dot(place, side)) / slope
        spot = self._spots[anchor]
        leg = self.map.legs[spot.leg]
        at_m = leg.begins_m + away_m if leads > 0 else leg.ends_m - away_m
        if abs(at_m - spot.along_m) <= _MOST_MOVED_M:
            self._spots[anchor] = spot._replace(along_m=at_m)

    # --- what the legs are like ---------------------------------------------------------------

    def _feel(self, look: Look) -> None:
        """Take note of gravity in the leg of the part that feels it."""
        around, spot = look.around, self._spots.get(look.part)
        if spot is None or look.at_s < self._felt_s + 0.2 or isnan(around.pitch_rad):
            return
        self._felt_s = look.at_s
        leg, made = self.map.legs[spot.leg], self.map
        leg.pitches_rad.append(around.pitch_rad)
        roll_rad = around.roll_rad - self._twist(look, look.part)
        if not isnan(roll_rad) and abs(around.pitch_rad) < _STEEP_RAD:
            leg.rolls_rad.append(roll_rad)
        if spot.leg == made.start[0] and not made.bends:
            made.pitch_rad = middle(leg.pitches_rad)
            if len(leg.rolls_rad) <= _FELT:
                made.roll_rad = middle(leg.rolls_rad)

    def _roll_of_part(self, look: Look, part: int) -> float:
        """Return the roll of a part's plane against the frame that is carried along, rad."""
        leg = self._spots[part].leg
        felt_rad, frame_rad = self.map.legs[leg].rolls_rad[-_FELT:], self.map.roll_of(leg)
        if felt_rad and not isnan(frame_rad):
            self._rho_rad = remainder(middle(felt_rad) - frame_rad, 2 * pi)
        return self._rho_rad + self._twist(look, part)

    def _twist(self, look: Look, part: int) -> float:
        """Return the roll of a part's plane against that of the rear half, rad."""
        roll, ahead = (
            self._body.roll,
            part >= 0 and (self._body.parts[part].wheels[0] <= self._body.roll_link),
        )
        return look.numbers[roll] if roll >= 0 and ahead else 0.0

    def _measure(self, look: Look) -> None:
        """Take note of the diameters that parts along one axis show, and of how far they are."""
        axes = {
            part: axis_at(self._body, look.numbers, part) for part in self._spots if part != WHOLE
        }
        known = [axis for axis in axes.values() if axis is not None]
        together = len(known) > 1 and len({self._spots[part].leg for part in axes}) == 1
        parallel = together and _between(known[0], known[-1]) <= _PARALLEL_RAD
        for part, axis in axes.items():
            spot, shown_m = self._spots[part], self._shown(look, part)
            if axis is None or isnan(shown_m) or spot.wheels != self._body.wheels_of(part):
                continue
            if (parallel or not self._bores) and self._is_farther(part):
                self._bores.setdefault(part, deque(maxlen=_FELT)).append(shown_m)
            if not (parallel or self._lies(look, part)):
                continue
            places = [spot.along_m + self._ahead_of(look, wheel, axis) for wheel in spot.wheels]
            leg = self.map.legs[spot.leg]
            leg.reach(min(places), max(places))
            if parallel:
                leg.bores.append(Bore(min(places), max(places), shown_m))

    # --- the robot ----------------------------------------------------------------------------

    @property
    def _radius_m(self) -> float:
        return self._body.wheel_radius_m

    def _shown(self, look: Look, part: int) -> float:
        index = self._body.parts[part].diameter
        return look.numbers[index] if index >= 0 else nan

    def _bore(self, part: int) -> float:
        """Return the diameter that a part, or any other, has lately shown in a straight, m."""
        shown = self._bores.get(part) or next(iter(self._bores.values()), ())
        return middle(list(shown))

    def _is_farther(self, part: int) -> bool:
        """Return whether the robot has moved on since the diameter at a part last counted."""
        if abs(self._way_m - self._bored_m.get(part, -inf)) < _BORE_EVERY_M:
            return False
        self._bored_m[part] = self._way_m
        return True

    def _whole(self, look: Look) -> Frame | None:
        wheels = self._body.wheels_of(WHOLE)
        return axis_of(self._body, look.numbers, wheels, 2 * self._radius_m)

    def _frame(self, look: Look, part: int, spot: Spot) -> Frame | None:
        if part == WHOLE:
            return self._whole(look)
        return axis_of(self._body, look.numbers, spot.wheels, self._bore(part))

    def _ahead_of(self, look: Look, wheel: int, frame: Frame) -> float:
        """Return how far a wheel is ahead of the origin of a frame, m."""
        place = wheel_at(self._body, look.numbers, wheel)
        return dot(between(frame.origin, place), frame.ahead)


def _between(one: Frame, other: Frame) -> float:
    """Return the angle between two axes, rad."""
    return acos(max(-1.0, min(1.0, dot(one.ahead, other.ahead))))


def _across(direction: Vector, axis: Vector) -> Vector:
    """Return the part of a direction across an axis."""
    return combined((1.0, direction), (-dot(direction, axis), axis))


def _cross(one: Vector, other: Vector) -> Vector:
    (ax, ay, az), (bx, by, bz) = one, other
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
