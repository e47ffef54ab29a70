"""Decides when a detector word begins and ends, from the filtered positions of the wheels."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import inf, nan

from pirate_sm.core.events import DetectorWord, Look, WordWatch
from pirate_sm.core.geometry import Bend
from pirate_sm.core.models import Profile
from pirate_sm.robot.detectors.place_filter import (
    FORGOTTEN_M,
    SLACK_M,
    WINDOW_S,
    beyond_m,
    line_of,
    median_of,
    place_of,
    slope_of,
    word_at,
)

# --- places ---------------------------------------------------------------------------------------


_OLDEST_S = 0.6
"""A position older than this is unknown [decided]: at 0.15 m/s the robot is 90 mm farther."""


class Tracker:
    """Remembers the positions of the wheels in the last ``WINDOW_S``.

    Attributes:
        seen: The looks in the window.
        driven: Whether wheels were driven when it last saw something.
    """

    def __init__(self) -> None:
        self.seen: deque[Look] = deque()
        self.driven = False
        self._changed_s = -inf

    def see(
        self,
        time_s: float,
        places_m: Sequence[float] | None,
        *,
        driven: bool,
        seen_s: float | None = None,
    ) -> None:
        """Take in the positions of the wheels.

        Args:
            time_s: Time, not earlier than in any earlier call.
            places_m: Position of each wheel along the pipe, NaN if unknown; None: nothing new.
            driven: Whether wheels are driven. When this changes, earlier positions are forgotten.
            seen_s: When the wheels were there; by default now. Positions from before wheels began
                or ceased to be driven are ignored.
        """
        self._now_s = time_s
        if driven != self.driven:
            self.seen.clear()
            self.driven, self._changed_s = driven, time_s
        seen_s = time_s if seen_s is None else seen_s
        if places_m is None or seen_s < self._changed_s:
            return
        self.seen.append((seen_s, *places_m))
        while self.seen[0][0] < seen_s - WINDOW_S:
            self.seen.popleft()

    def place(self, wheel: int) -> float:
        """Return the filtered position of a wheel now, m; NaN if its last position is unknown.

        After the last look a driven wheel moves as most wheels do: along the pipe a wheel that cuts
        a corner goes faster for a moment.
        """
        if not self._fresh:
            return nan
        place_m = place_of(wheel, self.driven, len(self.seen), self.seen, self._work)
        late_s = self._now_s - self.seen[-1][0]
        return place_m + self._speed() * late_s if self.driven and late_s else place_m

    def speed(self) -> float:
        """Return the speed of the robot along the pipe in the window, m/s, positive onwards.

        It is the median of the slopes of the wheels' lines; NaN without two positions.
        """
        return self._speed() if self._fresh and len(self.seen) > 1 else nan

    @property
    def _fresh(self) -> bool:
        return bool(self.seen) and self.seen[-1][0] >= self._now_s - _OLDEST_S

    @property
    def _work(self) -> list[list[float]]:
        return [[0.0] * len(self.seen) for _ in range(3)]

    def _speed(self) -> float:
        work, slopes = self._work, []
        for wheel in range(len(self.seen[0]) - 1):
            known = line_of(wheel, len(self.seen), self.seen, work)
            if known > 1:
                slopes.append(slope_of(known, work))
        return median_of(slopes, len(slopes))


# --- words ----------------------------------------------------------------------------------------


REPEAT_SHARE = 0.5
"""After this share of its validity a word that still holds is repeated."""

LOOK_EVERY_S = 0.05
"""At 0.15 m/s a robot travels 8 mm in this time."""

SELDOM_S = 0.15
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

    Positions are filtered (:class:`~pirate_sm.robot.detectors.word_timing.Tracker`). The direction
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
        self._points = [  # for travel backward and forward
            tuple((point.wheel, error - point.passed_m) for point, error in points)
            for points in (
                [(word.backward, error) for word, error in self._words],
                [(word.forward, error) for word, error in self._words],
            )
        ]
        self._bends = tuple(bends)
        self._repeater = Repeater(valid_for_s)
        self._tracker = tracker or Tracker()
        self._direction = 0
        self._places_m: list[float] = []
        self._number = -1

    @property
    def due(self) -> str:
        """Return the word whose wheel is where it says, whether it may be reported or not."""
        return self._words[self._number][0].name if self._number >= 0 else ""

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
            self._direction, self._number = travel, -1
            self._repeater.say("", time_s)  # what follows is a new report
        points = self._points[self._direction > 0]
        self._places_m = [self._tracker.place(each) for each, _ in points if self._direction]
        self._number = word_at(self._number, self._direction, self._places_m, points, self._bends)
        return self._repeater.say("" if self.due in barred else self.due, time_s)

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
        said = self._repeater.silent(self.due)
        if driven != self._tracker.driven or (driven and travel != direction) or said is None:
            return None
        return WordWatch(
            places_m,
            due_s,
            LOOK_EVERY_S,
            self._tracker.seen,
            driven,
            direction,
            self._points[direction > 0],
            self._bends,
            self._number,
            self.due,
            self._repeater.valid_for_s,
            *said,
        )

    def wait_s(self, top_m_s: float) -> float:
        """Return after what time to look again, so that no word is late for it.

        Until then no driven wheel can reach a point where a word begins or ends. Where wheels are
        not driven, a robot that slides or is pushed past one is reported 0.1 s later.

        Args:
            top_m_s: The most that a wheel may move along the pipe in a second.
        """
        seldom_s = min(SELDOM_S, REPEAT_SHARE * self._repeater.valid_for_s)
        if self._tracker.driven:
            near_m = min(map(abs, self._to_points_m()), default=math.inf) - SLACK_M
            seldom_s = min(seldom_s, near_m / top_m_s)
        return max(LOOK_EVERY_S, seldom_s)

    def _to_points_m(self) -> Iterator[float]:
        """Yield how far wheels are beyond each point where a word begins or ends, m."""
        direction, points = self._direction, self._points[self._direction > 0]
        for bend in range(len(self._bends) if direction else 0):  # 0: before the first look
            for number in range(len(points)):
                way_m = beyond_m(number, bend, direction, self._places_m, points, self._bends)
                yield from (way_m, way_m - FORGOTTEN_M)

    def relieve(self, looks: Sequence[Look], said_s: float | None) -> None:
        """Take looks that others have made; at most the word was repeated, last at ``said_s``."""
        if said_s is not None:
            self._repeater.reported_s = said_s
        for time_s, *places_m in looks:
            self._tracker.see(time_s, places_m, driven=self._tracker.driven)

    def see(
        self, time_s: float, places_m: Sequence[float] | None, travel: int, seen_s: float
    ) -> None:
        """Take in positions of the wheels as they were at ``seen_s``; else as :meth:`look`."""
        self._tracker.see(time_s, places_m, driven=travel != 0, seen_s=seen_s)
