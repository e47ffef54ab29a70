"""Follows a robot through an unknown pipe: where it is, how long the legs are, how they meet.

A clamped part whose V shows the inner diameter of its leg lies along the leg: it is an anchor, and
moves by what the odometer counts. When another part clamps, the joint angles say where it is.

- Along the anchor's axis: in the same leg.
- Otherwise it is the first to reach into another leg. Its outermost link spans from wall to wall
  there and gives the axis of the new leg: both axes give the bend's angle, its plane and its place.
- When the part that comes last clamps, the other is the anchor already, and its place was only
  estimated: it was not pressed between the walls then. The outermost wheel of the last part still
  touches its wall in the leg behind, which gives the anchor's place in the new leg again.

Where the detector's words tell of a joint, they decide its places, in the leg behind and in the leg
ahead: so nothing that happens in between can make a leg longer or shorter.

Neglected: slip of all wheels of both parts together; motion of an anchor that no odometer sees.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence
from itertools import takewhile
from math import copysign, inf, isfinite, isnan, nan, pi, radians, remainder

from pirate_sm.core.errors import RecordingError
from pirate_sm.core.events import Observation
from pirate_sm.core.geometry import Frame, between, dot
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import WHOLE, RobotLook
from pirate_sm.lab.mapping.axes import axis_at
from pirate_sm.lab.mapping.bend_angles import (
    ReachedBend,
    angle_between,
    angle_of_corner,
    angle_of_elbow,
    apart_rad,
    away_by_last_wheel,
    outermost,
    reached,
)
from pirate_sm.lab.mapping.legs import STEP, Bore, Leg, Map, MappedBend, feel_angles, round_elbows
from pirate_sm.lab.mapping.looks import JointEnd, WordPlace, WordReader, looks
from pirate_sm.lab.mapping.places import (
    ALONG_RAD,
    Anchor,
    Approach,
    BendPassage,
    PartPlaces,
    Rolls,
    Shape,
    Spot,
)
from pirate_sm.robot.detectors.place_filter import WINDOW_S
from pirate_sm.robot.detectors.word_timing import Word, words_of
from pirate_sm.running.recording.read.pieces import RecordedStep
from pirate_sm.running.recording.read.reader import Recording
from pirate_sm.running.recording.recorded_mission import recorded_robot_files, robot_as_recorded

_PARALLEL_RAD = radians(2)
"""Two parts whose axes differ by less show the diameters of plain pipes [decided]."""

_ONE_AXIS_RAD = radians(5)
"""Parts that differ by more do not lie in one leg [measured]."""

_SLIPPED_M = 0.02
"""By up to so much less a part has travelled than a detector counts that goes by its wheels: 4 to
9 mm in bends of six missions [measured]."""

_WAITED_S = 0.25
"""A detector says that a bend is passed once the shape has fitted for four looks, which are 0.2 s
[decided]."""

_STILL_RAD = radians(3)
"""Joints that differ by less from the start have not moved [decided]."""

_MOST_MOVED_M = 0.05
"""By more than this the anchor's place in a new leg is not corrected [decided]."""


class Mapper:
    """Makes a map of a pipe from looks at a robot that drives through it.

    Args:
        robot: The robot.
        words: The detector's words that have points.
        waits: Whether the detector says that a bend is passed only after a way rolled straight.

    Attributes:
        robot: The robot.
        map: The map so far.
        lost: Whether nothing is known any more of where the robot is.
    """

    def __init__(self, robot: RobotSpec, words: Sequence[Word], *, waits: bool) -> None:
        self.map = Map()
        self.lost = False
        self.robot, self._body = robot, robot.body
        self._shape, self._reader = Shape(robot.body), WordReader(words)
        self._places, self._rolls = PartPlaces(robot, self._shape), Rolls(self.map, robot.body)
        self._approach: Approach | None = None
        self._started: tuple[float, ...] = ()
        self._looks: deque[RobotLook] = deque()
        self._passage: BendPassage | None = None
        self._newest: BendPassage | None = None
        self._announced = ""
        self._waits, self._apart_m = waits, nan
        """Where the parts did not yet lie along one axis after the newest bend, as a way."""

    def look(self, look: RobotLook) -> None:
        """Take what is known at another time into the map."""
        if self.lost:
            return
        self._announced = look.announced or self._announced
        self._looks.append(look)
        while self._looks[0].at_s < look.at_s - _WAITED_S:
            self._looks.popleft()
        self._places.move(look)
        if not self._places.spots:
            self._begin(look)
            return
        self._release(look)
        if self._newest is not None and apart_rad(self._body, look) > _PARALLEL_RAD:
            self._apart_m = self._places.ways_m[0]
        self._tell(look)
        anchor, passage = self._places.anchor(look), self._passage
        for part in sorted(look.held - self._places.spots.keys()):
            if anchor is not None and self._along(look, part, anchor):
                continue
            if passage is not None:
                if part == passage.anchor.part and not passage.placed:
                    self._correct(look, passage)
            elif anchor is not None and not look.driven:
                self._reach_into(look, part, anchor)
        self._rolls.feel(look, self._places.spots)
        self._measure(look)

    def finish(self) -> Map:
        """Return the map; to be called after the last look."""
        feel_angles(self.map)
        round_elbows(self.map)
        if self._passage is not None and not self._passage.passed:
            self.map.notes.append(
                "the last bend was not passed, so its angle and its place are not sure"
            )
        return self.map

    # --- where the robot is -------------------------------------------------------------------

    def _begin(self, look: RobotLook) -> None:
        """Begin once all joints are known; the middle of the robot is the origin of its leg."""
        frame = self._shape.whole(look)
        if frame is None:
            return
        self._places.spots[WHOLE] = Spot(0, 0.0, self._body.wheels_of(WHOLE))
        self._started = self._body.angles(look.numbers)
        self._start_at(look, frame, 0.0)
        if look.held:
            self._release(look)

    def _start_at(self, look: RobotLook, frame: Frame, along_m: float) -> None:
        """Take the wheels' present places as those at the start."""
        wheels = self._body.wheels_of(WHOLE)
        places = [along_m + self._shape.ahead_of(look, wheel, frame) for wheel in wheels]
        self.map.legs[0] = leg = Leg()
        leg.reach(*places)
        self.map.start = (0, places[0])

    def _release(self, look: RobotLook) -> None:
        """Forget parts that hold no more; a robot that nothing holds lies where it was."""
        before = dict(self._places.spots)
        for part in self._places.spots.keys() - look.held:
            del self._places.spots[part]
        if self._places.spots:
            return
        known = next(iter(before.items()))
        frame = self._shape.frame(look, *known)
        if not look.held:
            self._places.spots[WHOLE] = (
                known[1] if known[0] == WHOLE else self._places.laid(look, *known)
            )
        elif frame is not None and known[0] == WHOLE:
            part = min(look.held)
            axis = axis_at(self._body, look.numbers, part)
            if axis is not None:
                away_m = dot(between(frame.origin, axis.origin), axis.ahead)
                wheels, place_m = self._body.wheels_of(part), known[1].along_m + away_m
                self._places.spots[part] = Spot(known[1].leg, place_m, wheels)
                if self._as_started(look):  # it was clamped already
                    self._start_at(look, axis, place_m)
        else:
            self.lost = True
            self.map.notes.append(f"the robot's place was lost at {look.at_s:.1f} s")

    def _as_started(self, look: RobotLook) -> bool:
        """Return whether the robot has neither moved nor changed its shape since the start."""
        pairs = zip(self._started, self._body.angles(look.numbers), strict=True)
        return not any(self._places.ways_m) and all(
            abs(one - now) < _STILL_RAD for one, now in pairs
        )

    # --- another part clamps ------------------------------------------------------------------

    def _along(self, look: RobotLook, part: int, anchor: Anchor) -> bool:
        """Place a part in the anchor's leg if it lies along it; return whether it does."""
        own, axis = axis_at(self._body, look.numbers, part), anchor.axis
        lies = self._shape.lies(look, part) or self._shape.lies(look, part, anchor.part)
        if own is None:
            return False
        if not self._is_behind(look) and (not lies or angle_between(own, axis) > ALONG_RAD):
            return False
        away = between(axis.origin, own.origin)
        place_m = anchor.along_m + copysign(dot(away, away) ** 0.5, dot(away, axis.ahead))
        leg = self._places.spots[anchor.part].leg
        self._places.spots[part] = Spot(leg, place_m, self._body.wheels_of(part))
        if self._passage is not None and self._passage.anchor.part == part:
            self._passage = None
        return True

    def _is_behind(self, look: RobotLook) -> bool:
        """Return whether a word says that the whole robot is behind a bend, in one leg."""
        newest = self._newest
        return newest is not None and newest.passed and newest.leads == look.travel

    def _reach_into(self, look: RobotLook, part: int, anchor: Anchor) -> None:
        """Find the bend between the anchor and a part that has gone first into another leg."""
        leads = 1 if self._body.wheels_of(part) < self._body.wheels_of(anchor.part) else -1
        numbers, bore_m = look.numbers, self._shape.bore(part)
        if look.travel == -leads:
            return
        found = reached(self._body, numbers, anchor.axis, part, leads, bore_m)
        if found is None:
            return
        feel_angles(self.map)
        spot = self._places.spots[anchor.part]
        rolled, was_m = self._rolls.of_part(look, anchor.part, spot.leg), spot.along_m
        roll_rad = remainder(found.towards_rad + rolled, 2 * pi)
        bend = MappedBend(found.angle_rad, roll_rad, self._announced)
        self._announced = ""
        into, new = self.map.beyond(self._places.spots[anchor.part].leg, leads, bend)
        if new and leads < 0:  # the new leg is the first one
            self._places.spots = {
                n: each._replace(leg=each.leg + 1) for n, each in self._places.spots.items()
            }
            if self._approach is not None:
                self._approach.leg += 1
        passage = BendPassage(into - 1 if leads > 0 else into, leads, part, anchor, numbers, new)
        self._passage = self._newest = passage
        approach = self._approach
        at_m = anchor.along_m + leads * found.away_m
        if approach and approach.leads == leads:
            at_m = approach.begins_m
            bend.extent_m = leads * (approach.ends_m - approach.begins_m)
            if bend.is_round:
                parts, into_m = (part, anchor.part), leads * (was_m - at_m)
                bend.angle_rad = angle_of_elbow(self._body, numbers, bend, parts, into_m, bore_m)
            else:
                if not isnan(approach.ends_m):
                    at_m = (approach.begins_m + approach.ends_m) / 2
                corner = anchor.axis.moved(at_m - anchor.along_m)
                bend.angle_rad = angle_of_corner(
                    self._body, numbers, corner, part, leads, found.angle_rad
                )
        self._meet(passage, at_m)
        leg = self.map.legs[into]
        begins_m = leg.begins_m if leads > 0 else leg.ends_m
        wheels = outermost(self._body, part, leads)
        self._places.spots[part] = Spot(into, begins_m + leads * found.beyond_m, wheels)

    def _meet(self, passage: BendPassage, at_m: float) -> None:
        """Fix the place of a new bend in the leg behind, or places in that leg by a known bend."""
        leads = passage.leads
        leg = passage.bend if leads > 0 else passage.bend + 1
        behind = self.map.legs[leg]
        if not passage.new:
            self._places.shift(leg, (behind.ends_m if leads > 0 else behind.begins_m) - at_m)
        elif leads > 0:
            behind.ends_m = at_m
        else:
            behind.begins_m = at_m

    # --- words --------------------------------------------------------------------------------

    def _tell(self, look: RobotLook) -> None:
        """Take a word that has begun for the place of its joint."""
        told = self._reader.look(look, self._places.ways_m[0])
        if told is None:
            return
        leads, approach, passage = told.leads, self._approach, self._newest
        if told.end is JointEnd.BEGINS:
            found = self._place_of_word(
                look, told, {spot.leg for spot in self._places.spots.values()}
            )
            self._approach = Approach(found[0], leads, found[1]) if found else None
            self._newest = None
        elif told.end is JointEnd.INSIDE and approach is not None and approach.leads == leads:
            found = self._place_of_word(look, told, {approach.leg})
            if found is not None and isnan(approach.ends_m):
                approach.ends_m = found[1]
        elif told.end is JointEnd.PASSED and passage is not None and passage.leads == leads:
            passage.passed = True
            into = passage.bend + 1 if leads > 0 else passage.bend
            found, leg = self._place_of_word(look, told, {into}), self.map.legs[into]
            begins_m = leg.begins_m if leads > 0 else leg.ends_m
            if found is None or (
                self._waited(look, told, self.map.bends[passage.bend])
                and (found[1] - begins_m) * leads >= 0.0
            ):
                return
            if not passage.new:
                self._places.shift(into, begins_m - found[1])
            elif leads > 0:
                leg.begins_m = found[1]
            else:
                leg.ends_m = found[1]

    def _before(self, look: RobotLook, by_s: float) -> RobotLook:
        """Return the look that came so long before another one."""
        return next(each for each in self._looks if each.at_s >= look.at_s - by_s)

    def _waited(self, look: RobotLook, told: WordPlace, bend: MappedBend) -> bool:
        """Return whether a word that a bend is passed may have waited for the robot's shape.

        A detector may say it only once the parts lie along one axis, or once its wheel has rolled
        the word's way since. Such a word says only that the bend ends there or before.
        """
        late = apart_rad(self._body, self._before(look, _WAITED_S)) > _PARALLEL_RAD
        if self._waits and not bend.is_round:
            rolled_m = abs(self._places.ways_m[0] - self._apart_m)
            late = late or rolled_m > told.passed_m - _SLIPPED_M
        return late and apart_rad(self._body, look) <= _ONE_AXIS_RAD

    def _place_of_word(
        self, look: RobotLook, told: WordPlace, legs: Collection[int]
    ) -> tuple[int, float] | None:
        """Return where a word's joint is, as an index of a leg and a place in it.

        While no wheel is driven a detector filters places by their median, which is late.
        """
        then = look if look.driven else self._before(look, WINDOW_S / 4)
        for part, spot in sorted(
            self._places.spots.items(),
            key=lambda each: told.wheel not in self._body.wheels_of(each[0]),
        ):
            frame = self._shape.frame(then, part, spot)
            if spot.leg in legs and frame is not None:
                at_m = spot.along_m + self._shape.ahead_of(then, told.wheel, frame)
                return spot.leg, at_m - told.leads * told.passed_m
        return None

    def _correct(self, look: RobotLook, passage: BendPassage) -> None:
        """Correct the place in the new leg when the part that comes last clamps there."""
        passage.placed = True
        first, leads = passage.first, passage.leads
        axis, spot = axis_at(self._body, look.numbers, first), self._places.spots.get(first)
        if axis is None or spot is None:
            return
        shown_m, known_m = self._shape.shown(look, first), self._shape.bore(first)
        if abs(shown_m - known_m) > STEP * known_m:  # the new leg has another diameter
            self._shape.start_again(look, first)
            if isnan(self.map.bends[passage.bend].extent_m):
                self._refine(passage)
        bend = self.map.bends[passage.bend]
        towards = bend.roll_rad - self._rolls.of_part(look, first, spot.leg)
        away_m = away_by_last_wheel(
            self._body,
            look.numbers,
            axis,
            passage.anchor.part,
            ReachedBend(bend.angle_rad, towards, 0.0, 0.0),
            leads,
            self._shape.bore(passage.anchor.part),
        )
        leg = self.map.legs[spot.leg]
        at_m = leg.begins_m + away_m if leads > 0 else leg.ends_m - away_m
        if abs(at_m - spot.along_m) <= _MOST_MOVED_M:
            self._places.spots[first] = Spot(spot.leg, at_m, self._body.wheels_of(first))

    def _refine(self, passage: BendPassage) -> None:
        """Find a bend again, once the diameter after it is known."""
        bore_m, axis = self._shape.bore(passage.first), passage.anchor.axis
        found = reached(self._body, passage.numbers, axis, passage.first, passage.leads, bore_m)
        if found is not None and passage.new:
            self.map.bends[passage.bend].angle_rad = found.angle_rad
            self._meet(passage, passage.anchor.along_m + passage.leads * found.away_m)

    # --- what the legs are like ---------------------------------------------------------------

    def _measure(self, look: RobotLook) -> None:
        """Take note of the diameters that parts along one axis show, and of how far they are."""
        axes = {
            part: axis_at(self._body, look.numbers, part)
            for part in self._places.spots
            if part != WHOLE
        }
        known = [axis for axis in axes.values() if axis is not None]
        together = len(known) > 1 and len({self._places.spots[part].leg for part in axes}) == 1
        parallel = together and angle_between(known[0], known[-1]) <= _PARALLEL_RAD
        for part, axis in axes.items():
            spot, shown_m = self._places.spots[part], self._shape.shown(look, part)
            if axis is None or isnan(shown_m) or spot.wheels != self._body.wheels_of(part):
                continue
            self._shape.note_bore(look, part, self._places.ways_m[part], parallel=parallel)
            if not (parallel or self._shape.lies(look, part)):
                continue
            places = [
                spot.along_m + self._shape.ahead_of(look, wheel, axis) for wheel in spot.wheels
            ]
            leg = self.map.legs[spot.leg]
            leg.reach(min(places), max(places))
            if parallel:
                leg.bores.append(Bore(min(places), max(places), shown_m))


# --- maps of recordings --------------------------------------------------------------------------


def mapped(recording: Recording) -> Map:
    """Return the map of the pipe that a robot has driven through.

    Of the recording it reads the robot's files, the frames of its boards, the detector's words, its
    states and its setpoints, and quotes what an operator has said of places; neither truth, nor the
    pipe's file, nor reports from outside. It ends at the first gap of a repaired recording, as the
    robot may have moved in it.

    Raises:
        RecordingError: The recording is damaged, its robot cannot be loaded any more, or no wheel
            angles were reported, as in a trace.
    """
    loaded = recorded_robot_files(recording.header)
    robot = robot_as_recorded(loaded, recording.header)
    waits = recording.header.detector == "odometry"
    mapper = Mapper(robot, words_of(loaded.profile), waits=waits)
    seen: list[str] = []
    for look in looks(mapper.robot, _overheard(recording, seen), recording.origin_s):
        mapper.look(look)
    found = mapper.finish()
    found.seen = seen
    for gap in recording.gaps[:1]:
        found.notes.append(
            f"nothing is known from {gap.from_s:.1f} s to {gap.until_s:.1f} s, so it ends there"
        )
    if not isfinite(found.legs[0].from_m):
        raise RecordingError("nothing to map: the recording shows no angle of any wheel")
    return found


def _overheard(recording: Recording, seen: list[str]) -> Iterator[RecordedStep]:
    """Yield the steps of the recording up to a gap; note what an operator says in them."""
    after = min((gap.step for gap in recording.gaps), default=inf)
    for step in takewhile(lambda each: each.number < after, recording.steps()):
        if isinstance(step.event, Observation):
            seen.append(step.event.words)
        yield step
