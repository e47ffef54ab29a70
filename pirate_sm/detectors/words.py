"""When a word begins and ceases to hold, with the wheels at known places along the pipe."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from pirate_sm.model.events import DetectorWord
from pirate_sm.model.profile import Profile

# Every wheel must have gone back so far before the robot counts as travelling the other way:
# parts that bend move single wheels by more.
_TURNED_BACK_M = 0.01
# The last word of a bend is no longer said this far beyond its point.
_FORGOTTEN_M = 0.25
# Near the end of its validity a word that still holds is said again.
_REPEAT_SHARE = 0.5


@dataclass(frozen=True)
class Point:
    """Where a word begins to hold: a wheel, and how far it is beyond the crossing, m."""

    wheel: int
    passed_m: float


@dataclass(frozen=True)
class Word:
    """A detector word with its points for travel forward and backward."""

    name: str
    forward: Point
    backward: Point


def words_of(profile: Profile) -> tuple[Word, ...]:
    """The detector's words with wheels as indexes."""
    wheels = {wheel.name: index for index, wheel in enumerate(profile.body.wheels)}
    return tuple(
        Word(
            name,
            Point(wheels[each.forward.wheel], each.forward.passed),
            Point(wheels[each.backward.wheel], each.backward.passed),
        )
        for name, each in profile.detector.words.items()
    )


class Detector:
    """Says a word when it begins to hold, and again while it holds.

    Each word's points are off by a fixed error per run.

    Args:
        words: In the order in which a robot meets them at a bend.
        errors_m: Error of each word's points.
        crossings_m: Arc lengths of the bends.
        valid_for_s: How long a word is valid.
    """

    def __init__(
        self,
        words: Sequence[Word],
        errors_m: Sequence[float],
        crossings_m: Sequence[float],
        valid_for_s: float,
    ) -> None:
        self._words = tuple(zip(words, errors_m, strict=True))
        self._crossings = tuple(crossings_m)
        self._valid_for_s = valid_for_s
        self._direction = 0
        self._farthest: list[float] = []
        self._said = ""
        self._said_at = -math.inf

    def look(self, time_s: float, arcs: Sequence[float]) -> DetectorWord | None:
        """The word to say now, with the wheels at these arc lengths; None for silence."""
        self._follow(arcs)
        word = self._holding(arcs)
        if not word:
            self._said = ""
            return None
        due = time_s - self._said_at >= _REPEAT_SHARE * self._valid_for_s
        if word == self._said and not due:
            return None
        self._said, self._said_at = word, time_s
        return DetectorWord(word, self._valid_for_s)

    def _follow(self, arcs: Sequence[float]) -> None:
        """The direction of travel is that of the last common motion of all wheels."""
        if not self._farthest:
            self._farthest = list(arcs)
            return
        moved = [arc - was for arc, was in zip(arcs, self._farthest, strict=True)]
        if self._direction >= 0 and max(moved) < -_TURNED_BACK_M:
            self._direction, self._farthest = -1, list(arcs)
        elif self._direction <= 0 and min(moved) > _TURNED_BACK_M:
            self._direction, self._farthest = 1, list(arcs)
        elif self._direction > 0:
            self._farthest = list(map(max, arcs, self._farthest))
        elif self._direction < 0:
            self._farthest = list(map(min, arcs, self._farthest))

    def _holding(self, arcs: Sequence[float]) -> str:
        if self._direction == 0:
            return ""
        for crossing in self._crossings:
            holding = ""
            beyond = 0.0
            for word, error in self._words:
                point = word.forward if self._direction > 0 else word.backward
                passed = self._direction * (arcs[point.wheel] - crossing) - point.passed_m + error
                if passed >= 0.0:
                    holding, beyond = word.name, passed
            if holding and beyond < _FORGOTTEN_M:
                return holding
        return ""
