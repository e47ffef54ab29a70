"""The detector ``vision``, without its pixels: newest sighting in, detector words out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, isnan, nan
from typing import NamedTuple, Protocol, Self

from pirate_sm.core.effects import Effect, Ended, Log
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import Event, OutsideNumber, Sighting
from pirate_sm.core.geometry import Route, walls
from pirate_sm.core.profile import Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.simulation import Truth
from pirate_sm.robot.detectors.camera_watch import CameraWatch
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.place_filter import Tracker
from pirate_sm.robot.detectors.seen_places import OneMarker, Placing, SeenWheels
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S, WordDetector, words_of

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
