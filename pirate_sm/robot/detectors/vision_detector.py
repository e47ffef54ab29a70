"""The detector ``vision``, without its pixels: newest sighting in, detector words out.

A tag gives the middle and the heading of its link, and so both wheels of the link. A link whose
tag is not seen for a moment is laid onto its neighbours by the joint angles. A marker gives one
point of the robot; dead reckoning gives the shape and the heading of the chain. Each fault of a
camera silences the detector.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import cos, inf, isnan, nan, sin
from typing import NamedTuple, Protocol, Self

from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState, has_come
from pirate_sm.core.events import BuiltInFault, Event, FaultReport, OutsideNumber, Sighting, Truth
from pirate_sm.core.geometry import Place, Pose, Route, inner_corner, walls
from pirate_sm.core.models import Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import BodySpec
from pirate_sm.robot.detectors.dead_reckoning import Reckoned
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S, Tracker, WordDetector, words_of

# --- the camera -----------------------------------------------------------------------------------


SILENT_AFTER_S = 0.5
FROZEN_AFTER_S = 1.0
MOVED_AFTER_S = 1.0
LEAST_SPREAD = 8.0
"""Difference of the 5 % darkest and brightest pixels. Black shows 0, a lens cap 3, gain 0.12 24."""
MOST_RMS_PX = 3.0
"""A camera turned by 0.5 deg shows 4.6 px, which are 5 mm at the robot."""


class CameraWatch:
    """Finds what is wrong with the pictures of a camera.

    Each fault is reported when it begins, and again only if the camera was good in between. The
    limits were measured on synthetic pictures.

    Args:
        blind_after_s: How long nothing of a driven robot may be seen.

    Attributes:
        wrong: The fault that lasts; None while the camera is good.
    """

    def __init__(self, blind_after_s: float) -> None:
        self.wrong: BuiltInFault | None = None
        self._blind_after_s = blind_after_s
        self._last: Sighting | None = None
        self._arrived_s = 0.0
        self._changed_s = self._surveyed_s = self._found_s = 0.0

    def take(self, sighting: Sighting, now_s: float) -> None:
        """Take in a sighting that has arrived."""
        if self._last is None or sighting.digest != self._last.digest:
            self._changed_s = now_s
        if sighting.rms_px is None or sighting.rms_px <= MOST_RMS_PX:
            self._surveyed_s = now_s
        if sighting.marks:
            self._found_s = now_s
        self._last, self._arrived_s = sighting, now_s

    def look(self, now_s: float, why: str, *, driven: bool) -> list[FaultReport]:
        """Return the fault that begins now, if one does.

        Args:
            now_s: Time.
            why: Why the camera gives no pictures; empty if nothing is known.
            driven: Whether wheels are driven.
        """
        if not driven:
            self._found_s = now_s
        was, (self.wrong, detail) = self.wrong, self._fault(now_s, why)
        if self.wrong is None or self.wrong is was:
            return []
        return [self.wrong.report(f"{self.wrong.meaning}{detail}")]

    def _fault(self, now_s: float, why: str) -> tuple[BuiltInFault | None, str]:
        """Return what is wrong now, and what to add to its meaning."""
        last = self._last
        if has_come(now_s, self._arrived_s + SILENT_AFTER_S):
            return BuiltInFault.VISION_SILENT, why and f": {why}"
        if last is None:
            return None, ""
        if has_come(now_s, self._changed_s + FROZEN_AFTER_S):
            return BuiltInFault.VISION_FROZEN, ""
        if last.gray_spread < LEAST_SPREAD:
            spread = f"{last.gray_spread:.0f} of 255"
            return BuiltInFault.VISION_DARK, f": dark and bright differ by {spread}"
        if has_come(now_s, self._surveyed_s + MOVED_AFTER_S):
            off = f"{last.rms_px:.1f} px off; survey it again"
            return BuiltInFault.VISION_MOVED, f": the setup's tags are {off}"
        if has_come(now_s, self._found_s + self._blind_after_s):
            return BuiltInFault.VISION_BLIND, ""
        return None, ""


# --- where the wheels are -------------------------------------------------------------------------


BRIDGED_S = 0.3
"""How long joint angles stand in for a tag that is not seen [decided]: it drives 30 mm in it."""

_UNKNOWN: Place = (nan, nan)


class SeenWheels(NamedTuple):
    """Where the wheels were at the time of a sighting; NaN is unknown.

    Attributes:
        places_m: Position of each wheel along the pipe; NaN also for one outside of it.
        points: The same positions in the plane of the pipe.
    """

    places_m: tuple[float, ...]
    points: tuple[Place, ...]

    @property
    def outside(self) -> bool:
        """Return whether a wheel was seen outside of the pipe, where none can be."""
        pairs = zip(self.places_m, self.points, strict=True)
        return any(isnan(place) and not isnan(x) for place, (x, _) in pairs)


class Placing(Protocol):
    """A way to find the wheels from what was seen."""

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        """Return where the wheels were; ``angles`` has the angle at each wheel, rad."""


class Tags:
    """Finds the wheels from tags on the links.

    Args:
        body: The robot's chain.
        route: The route through the pipe.
        links: Index of the link of each module with a tag.
    """

    def __init__(self, body: BodySpec, route: Route, links: Mapping[str, int]) -> None:
        self._body = body
        self._route = route
        self._links = links
        self._origin = inner_corner(route)
        self._seen_s = [-inf] * len(body.lengths_m)

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        """Return where the wheels were."""
        chains = []
        for mark in sighting.marks:
            if mark.heading_rad is not None:
                link = self._links[mark.on]
                self._seen_s[link] = sighting.captured_s
                chains.append((link, self._laid(mark.place_m, mark.heading_rad, link, angles)))
        if not chains:
            return _nowhere(len(angles))
        points = [self._wheel(wheel, chains, sighting.captured_s) for wheel in range(len(angles))]
        return _along(self._route, points)

    def _laid(
        self, place_m: Place, heading_rad: float, link: int, angles: Sequence[float]
    ) -> Sequence[Place]:
        """Return all wheels, in the plane of the pipe, by the tag of one link and the joints."""
        half_m = self._body.lengths_m[link] / 2
        x = place_m[0] + self._origin[0] + half_m * cos(heading_rad)
        y = place_m[1] + self._origin[1] + half_m * sin(heading_rad)
        return self._body.places(angles, link, Pose(x, y, heading_rad))

    def _wheel(
        self, wheel: int, chains: Sequence[tuple[int, Sequence[Place]]], captured_s: float
    ) -> Place:
        """Return the mean of what the tags of its links show, else what the nearest tag shows."""
        shown = [places[wheel] for link, places in chains if wheel in (link, link + 1)]
        if shown:
            return (sum(x for x, _ in shown) / len(shown), sum(y for _, y in shown) / len(shown))
        link, places = min(chains, key=lambda each: abs(each[0] + 0.5 - wheel))
        oldest_s = min(self._seen_s[min(wheel, link) : max(wheel, link)])
        return places[wheel] if captured_s - oldest_s <= BRIDGED_S else _UNKNOWN


class OneMarker:
    """Finds the wheels from one marker, with the shape of the chain by dead reckoning.

    Args:
        route: The route through the pipe.
        link: Index of the link in whose middle the marker is.
    """

    def __init__(self, route: Route, link: int) -> None:
        self._route = route
        self._link = link
        self._origin = inner_corner(route)
        self.reckoned: Reckoned | None = None

    def place(self, sighting: Sighting, angles: Sequence[float]) -> SeenWheels:
        """Return where the wheels were, with the shape in ``reckoned``."""
        if self.reckoned is None or not sighting.marks:
            return _nowhere(len(angles))
        points, mark = self.reckoned.points, sighting.marks[0]
        (ax, ay), (bx, by) = points[self._link], points[self._link + 1]
        dx = mark.place_m[0] + self._origin[0] - (ax + bx) / 2
        dy = mark.place_m[1] + self._origin[1] - (ay + by) / 2
        return _along(self._route, [(x + dx, y + dy) for x, y in points])


def _nowhere(wheels: int) -> SeenWheels:
    return SeenWheels((nan,) * wheels, (_UNKNOWN,) * wheels)


def _along(route: Route, points: Sequence[Place]) -> SeenWheels:
    return SeenWheels(tuple(_arc(route, point) for point in points), tuple(points))


def _arc(route: Route, point: Place) -> float:
    """Return where a point is along the pipe; NaN if it is unknown or outside of the pipe.

    In the outer corner of a square mitre the wall is 0.71 of the diameter from the centre line, so
    a whole diameter allows for errors, and for no other pipe [decided].
    """
    arc_m, away_m = route.nearest((*point, 0.0))
    return arc_m if away_m < route.piece_at(arc_m).diameter_m else nan


# --- the detector ---------------------------------------------------------------------------------


_FASTEST_M_S = 0.3
"""Three times as fast as the robot drives [decided]; what moves faster is no sighting of it."""
_SLACK_M = 0.02
_DOUBTED_S = 1.0
"""Sightings that contradict the last believed one are believed after this time."""
SHOWN_EVERY_S = 0.5
_APART_M = 0.05
"""A difference of seen and reckoned positions that is worth a warning [decided]."""


class Picture(Protocol):
    """A picture of the camera."""

    @property
    def sighting(self) -> Sighting:
        """Return what was found in it."""

    def jpeg(self) -> bytes:
        """Return it as a small JPEG."""


class SightingSource(Protocol):
    """An open camera, with what finds the robot in its pictures."""

    @property
    def due_s(self) -> float:
        """Return the mission time at which it wants to be asked again."""

    @property
    def fault(self) -> str:
        """Return why there are no pictures now; empty if there are."""

    def look(self, now_s: float) -> Sequence[Picture]:
        """Return what has arrived since it was asked last, oldest first; it never waits."""

    def close(self) -> None:
        """Close the camera."""


class CameraView(NamedTuple):
    """What a recording keeps of the camera at one moment.

    Attributes:
        seen: The newest positions.
        sighting: The newest sighting.
        jpeg: Its picture, at most twice a second and with each word; empty otherwise.
    """

    seen: SeenWheels
    sighting: Sighting
    jpeg: bytes


class CameraSight:
    """A companion that finds the wheels in a camera's sightings and reports detector words.

    No word is reported while the camera has a fault or the position of a word's wheel is unknown.
    Positions are read ahead to the present only while wheels are driven.

    Args:
        profile: The robot's profile, with its detector words.
        robot: The robot as the engine knows it.
        route: The route through the pipe.
        opens: Opens the camera when this companion is entered.
        placing: Finds the wheels in a sighting.
        odometry: Dead reckoning beside it, for the shape of the chain and as a second opinion.
        live: Whether the camera runs in real time, so that simulated time must not jump ahead.
        measures: The outside signal that gets the speed of the robot; empty for none.

    Attributes:
        seen: The newest positions; None before the first ones.
        newest: The newest picture; None before the first one.
    """

    def __init__(
        self,
        profile: Profile,
        robot: RobotSpec,
        route: Route,
        opens: Callable[[], SightingSource],
        placing: Placing,
        *,
        odometry: Odometry | None = None,
        live: bool = False,
        measures: str = "",
    ) -> None:
        self.due_s = 0.0
        self.listening = live
        self.seen: SeenWheels | None = None
        self.newest: Picture | None = None
        self._robot, self._placing, self._odometry = robot, placing, odometry
        self._opens = opens
        self._source: SightingSource | None = None
        self._shown_s = -inf
        self._measures = measures
        self._radius_m, self._walls = profile.body.wheel_radius, walls(route)
        self._watch = CameraWatch(profile.detector.valid_for)
        words, valid_for_s = words_of(profile), profile.detector.valid_for
        self._tracker, errors = Tracker(), (0.0,) * len(words)
        self._detector = WordDetector(words, errors, route.bends, valid_for_s, self._tracker)
        self._believed_s, self._believed_m = nan, (nan,) * len(robot.body.joints)
        self._apart = False
        self._inside_s: float | None = None
        self._events: list[Event] = []

    def __enter__(self) -> Self:
        """Open the camera.

        Raises:
            UsageError: It cannot be opened.
        """
        self._source = self._opens()
        return self

    def __exit__(self, *_: object) -> None:
        """Close the camera."""
        if self._source is not None:
            self._source.close()

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Stop looking at the end of the run."""
        if any(isinstance(effect, Ended) for effect in effects):
            self.due_s, self.listening = inf, False

    def restart(self, robot: RobotSpec) -> None:
        """Follow this robot from now on."""
        self._robot = robot
        if self._odometry is not None:
            self._odometry.restart(robot)

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Look at what the camera has seen since the last look; return messages for people."""
        assert self._source is not None, "the run enters it first"
        if self._odometry is not None:
            self._odometry.look(state, now_s)
            if isinstance(self._placing, OneMarker):
                self._placing.reckoned = self._odometry.reckoned
        travel, was_wrong = self._robot.travel(state.robot.values), self._watch.wrong
        angles = self._robot.body.angles(state.sensing.numbers)
        logs: list[Log] = []
        for picture in self._source.look(now_s):
            self.newest = picture
            self._watch.take(picture.sighting, now_s)
            places, outside = self._believed(picture.sighting, angles)
            logs += self._wrong_pipe(picture.sighting.captured_s, outside=outside)
            if places is not None:
                self._detector.see(now_s, places, travel, picture.sighting.captured_s)
                self._measure(places, now_s - picture.sighting.captured_s)
                logs += self._second_opinion(places)
        self._events += self._watch.look(now_s, self._source.fault, driven=travel != 0)
        word = self._detector.look(now_s, None, travel)
        if word is not None and not self._watch.wrong:
            self._events.append(word)
            self._shown_s = -inf
        if was_wrong and not self._watch.wrong:
            logs.append(Log("info", "the camera sees the robot again"))
        return logs

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the camera's faults, the word to report, and the speed if it is measured."""
        assert self._source is not None, "the run enters it first"
        due_s = self._source.due_s
        self.due_s = min(now_s + LOOK_EVERY_S, due_s if due_s > now_s else inf)
        events, self._events = tuple(self._events), []
        return events

    def view(self) -> CameraView | None:
        """Return what a recording keeps of this moment; None before the first sighting."""
        if self.seen is None:
            return None
        assert self.newest is not None, "in it something was seen"
        sighting, jpeg = self.newest.sighting, b""
        if sighting.captured_s >= self._shown_s + SHOWN_EVERY_S:
            self._shown_s, jpeg = sighting.captured_s, self.newest.jpeg()
        return CameraView(self.seen, sighting, jpeg)

    def truth(self) -> Truth | None:
        """Return the seen position for views; None while the position of a wheel is unknown."""
        if self.seen is None or any(isnan(place) for place in self.seen.places_m):
            return None
        return Truth(self.seen.points, self._radius_m, self._walls, self.seen.places_m[0])

    def _believed(
        self, sighting: Sighting, angles: Sequence[float]
    ) -> tuple[tuple[float, ...] | None, bool]:
        """Return the positions in a sighting, and whether a wheel is outside of the pipe.

        The positions are None if the robot cannot have moved that far.
        """
        seen = self._placing.place(sighting, angles)
        passed_s = sighting.captured_s - self._believed_s
        limit_m = _FASTEST_M_S * passed_s + _SLACK_M
        moved_m = [
            abs(now - before) for now, before in zip(seen.places_m, self._believed_m, strict=True)
        ]
        if passed_s <= _DOUBTED_S and any(each > limit_m for each in moved_m):  # false for NaN
            return None, seen.outside
        if not all(map(isnan, seen.places_m)):
            self._believed_s, self._believed_m = sighting.captured_s, seen.places_m
            self.seen = seen
        return seen.places_m, seen.outside

    def _wrong_pipe(self, captured_s: float, *, outside: bool) -> Sequence[Log]:
        """Return, once, a warning that the robot is seen outside of the pipe all the time."""
        if not outside or self._inside_s is None:
            self._inside_s = captured_s
        if captured_s - self._inside_s < _DOUBTED_S:
            return ()
        self._inside_s = inf  # it is said once
        message = "the camera sees wheels outside of the pipe, whose positions count as unknown"
        return (Log("warning", f"{message}: is it another pipe, or was the camera moved?"),)

    def _measure(self, places_m: Sequence[float], age_s: float) -> None:
        """Report the mean speed in the window that ended ``age_s`` ago, positive ahead."""
        speed_m_s = self._tracker.speed()
        known_m = [place for place in places_m if not isnan(place)]
        if self._measures and len(known_m) > 1 and not isnan(speed_m_s):
            ahead = -1.0 if known_m[0] < known_m[-1] else 1.0
            self._events.append(OutsideNumber(self._measures, ahead * speed_m_s, age_s))

    def _second_opinion(self, places_m: Sequence[float]) -> Sequence[Log]:
        """Return, once, a warning that seen and reckoned positions are far apart."""
        reckoned = self._odometry.reckoned if self._odometry is not None else None
        if reckoned is None or isinstance(self._placing, OneMarker):
            return ()
        apart_m = [abs(a - b) for a, b in zip(places_m, reckoned.places_m, strict=True)]
        far_m = max((each for each in apart_m if not isnan(each)), default=0.0)
        was, self._apart = self._apart, far_m > (_APART_M / 2 if self._apart else _APART_M)
        if was or not self._apart:
            return ()
        message = f"the camera and dead reckoning differ by {far_m * 1000:.0f} mm"
        return (Log("warning", f"{message}; the camera counts"),)
