"""Follows a robot through an unknown pipe: where it is, how long the legs are, how they meet.

A clamped part whose V shows the inner diameter of its leg lies along the leg: it is an anchor, and
moves by what the odometer counts. When another part clamps, the joint angles say where it stands.

- Along the anchor's axis: in the same leg.
- Otherwise it is the first to reach into another leg. Its outermost link stands from wall to wall
  there and gives the axis of the new leg: both axes give the bend's angle, its plane and its place.
- When the part that comes last clamps, the other is the anchor already, and its place was only
  estimated: it was not pressed between the walls then. The outermost wheel of the last part still
  touches its wall in the leg behind, which gives the anchor's place in the new leg anew.

Neglected: slip of all wheels of both parts at once; motion of an anchor that no odometer sees.
"""

from __future__ import annotations

from collections import deque
from math import inf, isnan, nan, pi, radians, remainder

from pirate_sm.detectors.leg_meetings import (
    Reached,
    angle_between,
    away_by_last_wheel,
    outermost,
    reached,
)
from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.engine.sensing.body_spec import WHOLE
from pirate_sm.engine.sensing.part_axes import axis_at, axis_of, wheel_at
from pirate_sm.geometry.space import Frame, between, dot
from pirate_sm.mapping.legs import Bend, Bore, Leg, Map, middle
from pirate_sm.mapping.looks import Look
from pirate_sm.mapping.spots import Anchor, Passage, Spot
from pirate_sm.mapping.way import Way

_AGREEING = 0.03
"""A V that shows the diameter of its leg up to this share lies along it [decided]."""

_ALONG_RAD = radians(10)
"""Two parts whose axes differ by less are in one leg [decided]."""

_PARALLEL_RAD = radians(2)
"""Two parts whose axes differ by less show the diameters of plain pipes [decided]."""

_STEEP_RAD = radians(60)
"""In a steeper leg a robot's roll is not taken from gravity [decided]."""

_FELT = 9
"""This number of the last rolls counts, and of the last diameters of a part."""

_BORE_EVERY_M = 0.02
"""The diameter that a part shows counts again after this distance [decided]."""

_STILL_RAD = radians(3)
"""Joints that differ by less from the start have not moved [decided]."""

_MOST_MOVED_M = 0.05
"""By more than this the anchor's place in a new leg is not corrected [decided]."""


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
        self._way = Way(robot)
        self._way_m = 0.0
        self._spots: dict[int, Spot] = {}
        self._bores: dict[int, deque[float]] = {}
        self._bored_m: dict[int, float] = {}
        self._started: tuple[float, ...] = ()
        self._links: dict[int, tuple[tuple[int, ...], float]] = {}
        self._passage: Passage | None = None
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
        anchor, passage = self._anchor(look), self._passage
        for part in sorted(look.held - self._spots.keys()):
            if anchor is not None and self._along(look, part, anchor):
                continue
            if passage is not None:
                if part == passage.last and not passage.placed:
                    self._correct(look, passage)
            elif anchor is not None and not look.driven:
                self._reach_into(look, part, anchor)
        self._feel(look)
        self._measure(look)

    def finish(self) -> Map:
        """Return the map; to be called after the last look."""
        if self._passage is not None:
            self.map.notes.append(
                "the last bend was not passed, so its angle and its place are not sure"
            )
        return self.map

    # --- where the robot is -------------------------------------------------------------------

    def _move(self, look: Look) -> None:
        """Move what is known by what the odometer has counted since the last look."""
        counted_m = self._way.until(look, [part for part in self._spots if part != WHOLE])
        moved_m, self._way_m = counted_m - self._way_m, counted_m
        for part, spot in self._spots.items():
            self._spots[part] = spot._replace(along_m=spot.along_m + moved_m)

    def _begin(self, look: Look) -> None:
        """Begin once all joints are known; the middle of the robot is the origin of its leg."""
        frame = self._whole(look)
        if frame is None:
            return
        self._spots[WHOLE] = Spot(0, 0.0, self._body.wheels_of(WHOLE))
        self._started = self._body.angles(look.numbers)
        self._start_at(look, frame, 0.0)
        if look.held:
            self._release(look)

    def _start_at(self, look: Look, frame: Frame, along_m: float) -> None:
        """Take the wheels' present places as those at the start."""
        wheels = self._body.wheels_of(WHOLE)
        places = [along_m + self._ahead_of(look, wheel, frame) for wheel in wheels]
        self.map.legs[0] = leg = Leg()
        leg.reach(*places)
        self.map.start = (0, places[0])

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
                wheels, place_m = self._body.wheels_of(part), known[1].along_m + away_m
                self._spots[part] = Spot(known[1].leg, place_m, wheels)
                if self._as_started(look):  # it was clamped already
                    self._start_at(look, axis, place_m)
        else:
            self.lost = True
            self.map.notes.append(f"the robot's place was lost at {look.at_s:.1f} s")

    def _as_started(self, look: Look) -> bool:
        """Return whether the robot has neither moved nor changed its shape since the start."""
        pairs = zip(self._started, self._body.angles(look.numbers), strict=True)
        return not self._way_m and all(abs(one - now) < _STILL_RAD for one, now in pairs)

    def _laid(self, look: Look, part: int, spot: Spot) -> Spot:
        """Return the place of the whole robot from that of a part."""
        frame, whole = self._frame(look, part, spot), self._whole(look)
        away_m = 0.0
        if frame is not None and whole is not None:
            away_m = dot(between(frame.origin, whole.origin), frame.ahead)
        return Spot(spot.leg, spot.along_m + away_m, self._body.wheels_of(WHOLE))

    def _anchor(self, look: Look) -> Anchor | None:
        """Return a part that lies along its leg, or whose outermost link does; None without one."""
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
            wheels = outermost(self._body, part, 1 if own[0] == 0 else -1)
            link = axis_of(self._body, look.numbers, wheels, self._bore(part))
            if link is not None:
                away_m = dot(between(frame.origin, link.origin), frame.ahead)
                self._links[part] = wheels, away_m
            return Anchor(part, frame, self._spots[part].along_m, whole=True)
        return self._pulled(look)

    def _pulled(self, look: Look) -> Anchor | None:
        """Return a part that another one has pulled out of shape, by its outermost link."""
        for part, spot in self._spots.items():
            if part in self._links and spot.wheels == self._body.wheels_of(part):
                wheels, away_m = self._links[part]
                frame = axis_of(self._body, look.numbers, wheels, self._bore(part))
                if frame is not None:
                    return Anchor(part, frame, spot.along_m + away_m, whole=False)
        return None

    def _lies(self, look: Look, part: int, like: int | None = None) -> bool:
        """Return whether the V of a part shows the diameter of its leg, or of another part's."""
        shown, known = self._shown(look, part), self._bore(part if like is None else like)
        return isnan(known) or abs(shown - known) <= _AGREEING * known

    # --- another part clamps ------------------------------------------------------------------

    def _along(self, look: Look, part: int, anchor: Anchor) -> bool:
        """Place a part in the anchor's leg if it lies along it; return whether it does."""
        own, axis = axis_at(self._body, look.numbers, part), anchor.axis
        lies = self._lies(look, part) or self._lies(look, part, anchor.part)
        if own is None or not lies or angle_between(own, axis) > _ALONG_RAD:
            return False
        place_m = anchor.along_m + dot(between(axis.origin, own.origin), axis.ahead)
        leg = self._spots[anchor.part].leg
        self._spots[part] = Spot(leg, place_m, self._body.wheels_of(part))
        if self._passage is not None and self._passage.last == part:
            self._passage = None
        return True

    def _reach_into(self, look: Look, part: int, anchor: Anchor) -> None:
        """Find the bend between the anchor and a part that has gone first into another leg."""
        leads = 1 if self._body.wheels_of(part) < self._body.wheels_of(anchor.part) else -1
        numbers, bore_m = look.numbers, self._bore(part)
        found = reached(self._body, numbers, anchor.axis, part, leads, bore_m)
        if found is None:
            return
        rolled = self._roll_of_part(look, anchor.part)
        roll_rad = remainder(found.towards_rad + rolled, 2 * pi)
        bend = Bend(found.angle_rad, roll_rad, self._announced)
        self._announced = ""
        into, new = self.map.beyond(self._spots[anchor.part].leg, leads, bend)
        if new and leads < 0:  # the new leg is the first one
            self._spots = {n: each._replace(leg=each.leg + 1) for n, each in self._spots.items()}
        passage = Passage(into - 1 if leads > 0 else into, leads, part, anchor, numbers, new)
        self._passage = passage
        self._meet(passage, found)
        leg = self.map.legs[into]
        begins_m = leg.begins_m if leads > 0 else leg.ends_m
        wheels = outermost(self._body, part, leads)
        self._spots[part] = Spot(into, begins_m + leads * found.beyond_m, wheels)

    def _meet(self, passage: Passage, found: Reached) -> None:
        """Fix the place of a new bend by the anchor, or the anchor's by a known bend."""
        leads, anchor = passage.leads, passage.anchor
        leg = passage.bend if leads > 0 else passage.bend + 1
        at_m, behind = anchor.along_m + leads * found.away_m, self.map.legs[leg]
        if not passage.new:
            known_m = behind.ends_m if leads > 0 else behind.begins_m
            for part, spot in self._spots.items():
                if spot.leg == leg:
                    self._spots[part] = spot._replace(along_m=spot.along_m + known_m - at_m)
        elif leads > 0:
            behind.ends_m = at_m
        else:
            behind.begins_m = at_m

    def _correct(self, look: Look, passage: Passage) -> None:
        """Correct the place in the new leg when the part that comes last clamps there."""
        passage.placed = True
        first, leads = passage.first, passage.leads
        axis, spot = axis_at(self._body, look.numbers, first), self._spots.get(first)
        if axis is None or spot is None:
            return
        if not self._lies(look, first):  # the new leg has another diameter
            self._bores[first] = deque([self._shown(look, first)], maxlen=_FELT)
            self._refine(passage)
        bend = self.map.bends[passage.bend]
        towards = bend.roll_rad - self._roll_of_part(look, first)
        away_m = away_by_last_wheel(
            self._body,
            look.numbers,
            axis,
            passage.anchor.part,
            Reached(bend.angle_rad, towards, 0.0, 0.0),
            leads,
            self._bore(passage.anchor.part),
        )
        leg = self.map.legs[spot.leg]
        at_m = leg.begins_m + away_m if leads > 0 else leg.ends_m - away_m
        if abs(at_m - spot.along_m) <= _MOST_MOVED_M:
            self._spots[first] = Spot(spot.leg, at_m, self._body.wheels_of(first))

    def _refine(self, passage: Passage) -> None:
        """Find a bend anew, once the diameter behind it is known."""
        bore_m, axis = self._bore(passage.first), passage.anchor.axis
        found = reached(self._body, passage.numbers, axis, passage.first, passage.leads, bore_m)
        if found is not None and passage.new:
            self.map.bends[passage.bend].angle_rad = found.angle_rad
            self._meet(passage, found)

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
        parallel = together and angle_between(known[0], known[-1]) <= _PARALLEL_RAD
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
