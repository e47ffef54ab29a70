"""What the joints of a robot show: axes of pipes at its parts, and the diameters there."""

from __future__ import annotations

from collections import deque
from math import isnan, nan

from pirate_sm.core.geometry import Frame, between, dot
from pirate_sm.core.sensing import WHOLE, BodySpec, axis_of, wheel_at
from pirate_sm.lab.mapping.legs import middle
from pirate_sm.lab.mapping.looks import RobotLook
from pirate_sm.lab.mapping.spots import Spot

_AGREEING = 0.05
"""A V that shows the diameter of its leg up to this share lies along it; one that lies slantwise in
a round pipe shows up to 5 % less [decided]."""

_LAST = 9
"""This number of the last diameters of a part counts."""

_BORE_EVERY_M = 0.02
"""The diameter that a part shows counts again after this distance [decided]."""


class Shape:
    """Knows the diameters that the parts have lately shown in a straight.

    Args:
        body: The robot's chain.
    """

    def __init__(self, body: BodySpec) -> None:
        self._body = body
        self._bores: dict[int, deque[float]] = {}
        self._bored_m: dict[int, float] = {}

    def shown(self, look: RobotLook, part: int) -> float:
        """Return the diameter that a part shows now, m; NaN if it is unknown."""
        index = self._body.parts[part].diameter
        return look.numbers[index] if index >= 0 else nan

    def bore(self, part: int) -> float:
        """Return the diameter that a part, or any other, has lately shown in a straight, m."""
        shown = self._bores.get(part) or next(iter(self._bores.values()), ())
        return middle(list(shown))

    def note_bore(self, look: RobotLook, part: int, way_m: float, *, parallel: bool) -> None:
        """Take note of what a part shows, once it is farther.

        Args:
            look: What is known of the robot.
            part: The part.
            way_m: How far it has travelled.
            parallel: Whether parts lie along one axis; the first diameter counts without that.
        """
        farther = part not in self._bored_m or abs(way_m - self._bored_m[part]) >= _BORE_EVERY_M
        if farther and (parallel or not self._bores):
            self._bored_m[part] = way_m
            self._bores.setdefault(part, deque(maxlen=_LAST)).append(self.shown(look, part))

    def start_again(self, look: RobotLook, part: int) -> None:
        """Take what a part shows for the diameter of a new leg."""
        self._bores[part] = deque([self.shown(look, part)], maxlen=_LAST)

    def lies(self, look: RobotLook, part: int, like: int | None = None) -> bool:
        """Return whether the V of a part shows the diameter of its leg, or of another part's."""
        shown, known = self.shown(look, part), self.bore(part if like is None else like)
        return isnan(known) or abs(shown - known) <= _AGREEING * known

    def whole(self, look: RobotLook) -> Frame | None:
        """Return the axis of the whole robot; None if a joint is unknown."""
        wheels = self._body.wheels_of(WHOLE)
        return axis_of(self._body, look.numbers, wheels, 2 * self._body.wheel_radius_m)

    def frame(self, look: RobotLook, part: int, spot: Spot) -> Frame | None:
        """Return the axis at the wheels of a spot."""
        if part == WHOLE:
            return self.whole(look)
        return axis_of(self._body, look.numbers, spot.wheels, self.bore(part))

    def ahead_of(self, look: RobotLook, wheel: int, frame: Frame) -> float:
        """Return how far a wheel is ahead of the origin of a frame, m."""
        place = wheel_at(self._body, look.numbers, wheel)
        return dot(between(frame.origin, place), frame.ahead)
