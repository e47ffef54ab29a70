"""What someone outside would report of the simulated robot: detector words and surroundings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pirate_sm.backends.simulator.geometry import GRAVITY_M_S2, Pipe
from pirate_sm.backends.simulator.world import World
from pirate_sm.model.events import DetectorWord, EnvironmentReport

# Every wheel must have gone back so far before the robot counts as travelling the other way:
# parts that bend move single wheels by more.
_TURNED_BACK_M = 0.01
# The last word of a bend is no longer said this far beyond its point.
_FORGOTTEN_M = 0.25
# Near the end of its validity a word that still holds is said again.
_REPEAT_SHARE = 0.5
# A wheel this near to a crossing makes the segment a joint.
_JOINT_REACH_M = 0.06
_PRESSED_N = 0.5


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


@dataclass(frozen=True)
class Vee:
    """A part whose V shows the pipe's diameter.

    Attributes:
        apex: Wheel that its apex joint sits at.
        length_m: Length of its legs.
        wheels: Wheels of the part.
    """

    apex: int
    length_m: float
    wheels: tuple[int, ...]


class Surroundings:
    """Reports the pipe around the robot when it changes.

    Args:
        parts: Parts that can clamp.
        wheel_radius_m: Of the wheels.
    """

    def __init__(self, parts: Mapping[str, Vee], wheel_radius_m: float) -> None:
        self._parts = tuple(parts.values())
        self._radius = wheel_radius_m
        self._key: tuple[object, ...] = ()

    def look(self, world: World, arcs: Sequence[float]) -> EnvironmentReport | None:
        """The report to make now; None when nothing has changed by 1 mm or 1 deg."""
        diameter = self._diameter(world)
        leg = world.pipe.leg_at(sum(arcs) / len(arcs))
        pitch = math.asin(min(1.0, max(-1.0, -leg.gravity[0] / GRAVITY_M_S2)))
        roll = -float(world.state.roll[1])
        segment = segment_of(world.pipe, arcs)
        known = None if math.isnan(diameter) else round(diameter * 1000)
        key = (segment, round(math.degrees(roll)), round(math.degrees(pitch)), known)
        if key == self._key:
            return None
        self._key = key
        return EnvironmentReport(segment, roll, pitch, diameter)

    def _diameter(self, world: World) -> float:
        """Mean of h + 2r over the parts that press with all their wheels (thesis eq. 3-2)."""
        press = world.values("press")
        found = [
            abs(vee.length_m * math.sin(world.state.bend[vee.apex] / 2.0)) + 2.0 * self._radius
            for vee in self._parts
            if min(press[wheel] for wheel in vee.wheels) > _PRESSED_N
        ]
        return float(sum(found) / len(found)) if found else math.nan


def segment_of(pipe: Pipe, arcs: Sequence[float]) -> str:
    """`Out` with most wheels outside, `Joint` with a wheel at a crossing, else `Straight`."""
    outside = sum(1 for arc in arcs if not 0.0 <= arc <= pipe.length_m)
    if 2 * outside > len(arcs):
        return "Out"
    low, high = min(arcs) - _JOINT_REACH_M, max(arcs) + _JOINT_REACH_M
    if any(low <= crossing <= high for crossing in pipe.crossings_m):
        return "Joint"
    return "Straight"
