"""Looks at a recorded robot: what is known of it at each step, without mission, pipe and truth.

Of a recording only these are read: the robot's own files, the frames of its boards, the detector's
words, and what it was commanded to: its states and its setpoints.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum
from typing import NamedTuple

from pirate_sm.core.effects import Setpoints, StateChange
from pirate_sm.core.events import DetectorWord, SensorFrame, SubmitResult
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.sensing import RobotListener, RobotLook
from pirate_sm.robot.detectors.word_timing import Word
from pirate_sm.running.recording.read.pieces import RecordedStep


def looks(
    robot: RobotSpec, steps: Iterable[RecordedStep], origin_s: float = 0.0
) -> Iterator[RobotLook]:
    """Yield what is known of the robot after each step that reports on it or commands it.

    Args:
        robot: The robot.
        steps: The steps of the recording.
        origin_s: When the run began, by the engine's clock.
    """
    listener = RobotListener(robot)
    for step in steps:
        heard = isinstance(step.event, SensorFrame | DetectorWord | SubmitResult)
        if heard or any(isinstance(each, StateChange | Setpoints) for each in step.effects):
            yield listener.hear(step.event, step.effects, step.at_s - origin_s)


# --- places of words -----------------------------------------------------------------------------
# A word begins when its wheel passes a point: a distance from where the axes meet, or, at an
# elbow, from where they would meet in a mitre that takes as much wall as its beginning or its end.
# The first word of a joint counts from its beginning, the others from its end.


_SURELY_M = 0.02
"""When the direction changes, a detector repeats its word; words count after this distance
[decided]."""


class JointEnd(Enum):
    """Which end of a joint a word counts from, and whether the whole robot is behind it."""

    BEGINS = "begins"
    INSIDE = "inside"
    PASSED = "passed"


class WordPlace(NamedTuple):
    """A word that has just begun.

    Attributes:
        end: What it counts from.
        wheel: The wheel that has reached its point.
        passed_m: How far that is behind the end, in the direction of travel.
        leads: The direction of travel: 1 forward, -1 backward.
    """

    end: JointEnd
    wheel: int
    passed_m: float
    leads: int


class WordReader:
    """Notes where words begin.

    Args:
        words: The detector's words that have points, in the order in which a robot reaches them.
    """

    def __init__(self, words: Sequence[Word]) -> None:
        self._words = {word.name: word for word in words}
        self._names = [word.name for word in words]
        self._before = ""
        self._travel = 0
        self._since_m = 0.0

    def look(self, look: RobotLook, way_m: float) -> WordPlace | None:
        """Return the word that has begun with this look.

        Args:
            look: What is known of the robot.
            way_m: How far it has travelled.
        """
        if look.travel != self._travel:
            self._travel, self._since_m, self._before = look.travel, way_m, ""
        if look.word and look.word not in self._words:
            return None
        before, self._before = self._before, look.word
        if look.word in ("", before):
            return None
        number = self._names.index(look.word)
        if before and self._names.index(before) > number:
            return None
        surely = look.driven and abs(way_m - self._since_m) >= _SURELY_M
        if not before and not surely:
            return None
        word = self._words[look.word]
        point = word.forward if look.travel > 0 else word.backward
        ends = {0: JointEnd.BEGINS, len(self._names) - 1: JointEnd.PASSED}
        end = ends.get(number, JointEnd.INSIDE)
        return WordPlace(end, point.wheel, point.passed_m, look.travel)
