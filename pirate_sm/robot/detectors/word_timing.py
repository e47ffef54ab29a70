"""Decides when a detector word begins and ends, from the positions of the wheels."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pirate_sm.core.events import DetectorWord, Look, WordWatch
from pirate_sm.core.geometry import Bend
from pirate_sm.core.profile import Profile
from pirate_sm.robot.detectors.place_filter import WINDOW_S, Tracker

# A word stays valid until its wheel is this far before the point, so that noise does not switch it
# on and off.
_SLACK_M = 0.01
# The last word of a bend ends this far beyond its point.
_FORGOTTEN_M = 0.25
REPEAT_SHARE = 0.5
"""After this share of its validity a word that still holds is repeated."""

LOOK_EVERY_S = 0.05
"""At 0.1 m/s a robot travels 5 mm in this time."""

SELDOM_S = 0.2
"""Where no word can begin or end before, looks are this far apart: a position is the median over
``WINDOW_S``, which still has three of them [decided]."""


@dataclass(frozen=True)
class Point:
    """Where a word begins: a wheel, and its distance beyond the crossing, m."""

    wheel: int
    passed_m: float


@dataclass(frozen=True)
class Word:
    """A detector word with its points for travel forward and backward."""

    name: str
    forward: Point
    backward: Point


def words_of(profile: Profile) -> tuple[Word, ...]:
    """Return the profile's detector words that have points, with wheels as indices."""
    wheels = {wheel.name: index for index, wheel in enumerate(profile.body.wheels)}
    return tuple(
        Word(
            name,
            Point(wheels[each.forward.wheel], each.forward.passed),
            Point(wheels[each.backward.wheel], each.backward.passed),
        )
        for name, each in profile.detector.words.items()
        if each.forward is not None and each.backward is not None
    )


class Repeater:
    """Reports a word when it begins, and again after half of its validity while it holds.

    Args:
        valid_for_s: How long a word is valid.

    Attributes:
        reported_s: When a word was reported last; NaN before the first one.
    """

    def __init__(self, valid_for_s: float) -> None:
        self.valid_for_s = valid_for_s
        self._word = ""
        self.reported_s = math.nan

    def say(self, word: str, now_s: float) -> DetectorWord | None:
        """Return the word to report now, given the one that holds (empty for none)."""
        due = now_s - self.reported_s >= REPEAT_SHARE * self.valid_for_s
        if word == self._word and not due:
            return None
        self._word = word
        if not word:
            return None
        self.reported_s = now_s
        return DetectorWord(word, self.valid_for_s)

    def silent(self, word: str) -> tuple[float, float] | None:
        """Return when a word was reported that holds, and after which time it is repeated.

        Without a word it is never repeated. None: the word that holds is not the reported one.
        """
        if word != self._word:
            return None
        return (self.reported_s, REPEAT_SHARE * self.valid_for_s) if word else (0.0, math.inf)


class WordDetector:
    """Reports a word when it begins, and repeats it while it holds.

    Positions are filtered (:class:`~pirate_sm.robot.detectors.place_filter.Tracker`). The direction
    of travel is that of the setpoints in force, or of the last ones that drove the wheels, because
    positions are too uncertain to show it. While the position of a word's wheel is unknown, neither
    this word nor an earlier one is reported, since the robot may be farther.

    Args:
        words: The words, in the order in which a robot reaches them at a bend.
        errors_m: Error of each word's points, fixed for a run.
        bends: The bends along the pipe. A mitre's words count from the crossing of its axes. In an
            elbow the first word counts from where it begins, the others from where it ends.
        valid_for_s: How long a word is valid.
        tracker: Filters the positions; by default one of its own.
    """

    def __init__(
        self,
        words: Sequence[Word],
        errors_m: Sequence[float],
        bends: Sequence[Bend],
        valid_for_s: float,
        tracker: Tracker | None = None,
    ) -> None:
        self._words = tuple(zip(words, errors_m, strict=True))[::-1]
        self._bends = tuple(bends)
        self._repeater = Repeater(valid_for_s)
        self._tracker = tracker or Tracker()
        self._direction = 0
        self._ways_m: list[list[float]] = []
        self._word = ""

    @property
    def due(self) -> str:
        """Return the word whose wheel is where it says, whether it may be reported or not."""
        return self._word

    def look(
        self,
        time_s: float,
        places_m: Sequence[float] | None,
        travel: int,
        barred: frozenset[str] = frozenset(),
    ) -> DetectorWord | None:
        """Return the word to report now; None if there is none.

        Args:
            time_s: Time.
            places_m: Position of each wheel along the pipe now, NaN if unknown; None: nothing new.
            travel: Direction in which the setpoints in force drive the wheels: 1 forward, -1
                backward, 0 not at all.
            barred: Words that are not reported now, though their wheels are there.
        """
        self.see(time_s, places_m, travel, time_s)
        if travel and travel != self._direction:
            self._direction, self._word = travel, ""
            self._repeater.say("", time_s)  # what follows is a new report
        self._ways_m = self._passed_m() if self._direction else []
        self._word = self._holding()
        return self._repeater.say("" if self._word in barred else self._word, time_s)

    def watch(
        self, places_m: Callable[[], Sequence[float]], due_s: float, travel: int
    ) -> WordWatch | None:
        """Return what it knows between two looks; None where only a look of its own will do.

        Args:
            places_m: Returns the position of each wheel.
            due_s: When it looks next.
            travel: As for :meth:`look`.
        """
        driven, direction = travel != 0, self._direction
        said = self._repeater.silent(self._word)
        if driven != self._tracker.driven or (driven and travel != direction) or said is None:
            return None
        names = [word.name for word, _ in self._words]
        return WordWatch(
            places_m,
            due_s,
            LOOK_EVERY_S,
            WINDOW_S,
            self._tracker.seen,
            driven,
            direction,
            self._points(direction),
            self._bends,
            _SLACK_M,
            _FORGOTTEN_M,
            names.index(self._word) if self._word else -1,
            self._word,
            self._repeater.valid_for_s,
            *said,
        )

    def wait_s(self) -> float:
        """Return after what time to look again, so that no word is told later for it.

        Half of the way to the nearest point where a word begins or ends may be travelled at the
        present speed. Wheels that are not driven bring about no word.
        """
        if not self._tracker.driven:
            return SELDOM_S
        speed = abs(self._tracker.speed())
        if math.isnan(speed):
            return LOOK_EVERY_S
        half_m = (self._clear_m() - _SLACK_M) / 2
        return min(SELDOM_S, max(LOOK_EVERY_S, half_m / speed if speed else math.inf))

    def _clear_m(self) -> float:
        """Return how far the wheels must travel until a word begins or ends, m."""
        clear_m = math.inf
        for ways_m in self._ways_m:
            for passed_m in ways_m:
                point_m = 0.0 if passed_m < 0.0 else _FORGOTTEN_M
                if passed_m < point_m:
                    clear_m = min(clear_m, point_m - passed_m)
        return clear_m

    def _points(self, direction: int) -> tuple[tuple[int, float], ...]:
        points = [(word.forward if direction > 0 else word.backward, e) for word, e in self._words]
        return tuple((point.wheel, error - point.passed_m) for point, error in points)

    def relieve(self, looks: Sequence[Look], said_s: float | None) -> None:
        """Take looks that others have made; at most the word was repeated, last at ``said_s``."""
        if said_s is not None:
            self._repeater.reported_s = said_s
        for time_s, places_m in looks:
            self._tracker.see(time_s, places_m, driven=self._tracker.driven)

    def see(
        self, time_s: float, places_m: Sequence[float] | None, travel: int, seen_s: float
    ) -> None:
        """Take in positions of the wheels as they were at ``seen_s``; else as :meth:`look`."""
        self._tracker.see(time_s, places_m, driven=travel != 0, seen_s=seen_s)

    def _passed_m(self) -> list[list[float]]:
        """Return, by bend and word, how far its wheel is beyond the point where it begins, m."""
        points = self._points(self._direction)
        places_m = [self._tracker.place(wheel) for wheel, _ in points]
        return [
            [
                self._direction * (place_m - crossing)
                + off_m
                + (reach if number == len(points) - 1 else -reach)
                for number, (place_m, (_, off_m)) in enumerate(zip(places_m, points, strict=True))
            ]
            for crossing, reach in self._bends
        ]

    def _holding(self) -> str:
        for ways_m in self._ways_m:
            for (word, _), passed_m in zip(self._words, ways_m, strict=True):  # the farthest first
                if math.isnan(passed_m):
                    return ""
                if passed_m >= (-_SLACK_M if word.name == self._word else 0.0):
                    if passed_m < _FORGOTTEN_M:
                        return word.name
                    break
        return ""
