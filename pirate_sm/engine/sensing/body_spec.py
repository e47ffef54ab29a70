"""The robot's chain of wheels and links in its plane, as the measured joint angles give it.

A joint's angle is the heading of the link behind it less that of the link ahead of it, counted
towards side A. An unknown angle is NaN; so is then every point and heading that rests on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, cos, hypot, isnan, nan, sin
from typing import NamedTuple

Point = tuple[float, float]

WHOLE = -1
"""In place of a part's index: the whole chain."""


class Vee(NamedTuple):
    """The V of a part that clamps.

    Attributes:
        wheels: Its wheels, front to rear.
        angle: Number index of the angle at its apex.
        diameter: Number index of the inner diameter that this angle gives; -1 without one.
        end_stop_rad: Largest angle that the apex can take, either way.
    """

    wheels: tuple[int, ...]
    angle: int
    diameter: int
    end_stop_rad: float


class Imu(NamedTuple):
    """Where the accelerometer sits: on the half of its link that is ahead of a roll joint.

    Attributes:
        link: Index of its link.
        axes: Number indexes of the acceleration along the link ahead, towards side B and up.
        roll: Number index of the angle by which its half is rolled against the rear; -1 without.
    """

    link: int
    axes: tuple[int, int, int]
    roll: int


@dataclass(frozen=True)
class BodySpec:
    """The robot's chain, front to rear.

    Attributes:
        lengths_m: Length of each link; the first one lies between wheels 0 and 1.
        joints: Per wheel the number index of its joint's angle; -1 without a joint.
        sides: Per wheel the side that it touches when its part is clamped: 1 is A, -1 is B.
        parts: The V of each part, in the order of the robot's parts.
        wheel_radius_m: Radius of the wheels.
        roll_link: Index of the link with a roll joint; -1 without one.
        imu: The accelerometer; None without one.
    """

    lengths_m: tuple[float, ...]
    joints: tuple[int, ...]
    sides: tuple[int, ...]
    parts: tuple[Vee, ...]
    wheel_radius_m: float
    roll_link: int = -1
    imu: Imu | None = None

    def wheels_of(self, part: int) -> tuple[int, ...]:
        """Return the wheels of a part, or of the ``WHOLE`` chain, front to rear."""
        return tuple(range(len(self.joints))) if part == WHOLE else self.parts[part].wheels

    def angles(self, numbers: Sequence[float]) -> tuple[float, ...]:
        """Return the angle at each wheel, rad: 0 without a joint, NaN where it is unknown."""
        return tuple(numbers[joint] if joint >= 0 else 0.0 for joint in self.joints)

    def headings(self, angles: Sequence[float], first: int) -> list[float]:
        """Return the heading of each link against that of the link behind wheel ``first``, rad."""
        first = min(first, len(self.lengths_m) - 1)  # no link is behind the last wheel
        headings = [0.0] * len(self.lengths_m)
        for link in range(first + 1, len(headings)):
            headings[link] = headings[link - 1] + angles[link]
        for link in range(first - 1, -1, -1):
            headings[link] = headings[link + 1] - angles[link + 1]
        return headings

    def shape(self, angles: Sequence[float], first: int) -> list[Point]:
        """Return the place of each wheel, m, with the link behind wheel ``first`` along x."""
        first = min(first, len(self.lengths_m) - 1)
        headings = self.headings(angles, first)
        steps = [
            (length * cos(heading), length * sin(heading))
            for length, heading in zip(self.lengths_m, headings, strict=True)
        ]
        points: list[Point] = [(0.0, 0.0)] * (len(steps) + 1)
        for wheel in range(first, len(steps)):
            (x, y), (along, across) = points[wheel], steps[wheel]
            points[wheel + 1] = (x - along, y - across)
        for wheel in range(first - 1, -1, -1):
            (x, y), (along, across) = points[wheel + 1], steps[wheel]
            points[wheel] = (x + along, y + across)
        return points

    def lean(self, points: Sequence[Point], wheels: Sequence[int], aside_m: float) -> float:
        """Return by how much a shape must be turned so that a part lies along the pipe, rad.

        Args:
            points: The places of all wheels.
            wheels: Those of the part, each of which touches its side of the pipe.
            aside_m: How far from the pipe's axis a wheel that touches a side is.
        """
        front, rear = wheels[0], wheels[-1]
        along, across = points[front][0] - points[rear][0], points[front][1] - points[rear][1]
        rise = (self.sides[front] - self.sides[rear]) * aside_m / (hypot(along, across) or 1.0)
        if isnan(rise):
            return nan
        return asin(max(-1.0, min(1.0, rise))) - atan2(across, along)

    def heading_in_pipe(self, numbers: Sequence[float], part: int, link: int) -> float:
        """Return a link's heading against the axis of the pipe in which a part is clamped, rad.

        Args:
            numbers: The engine's signals; NaN is unknown.
            part: Index of the part.
            link: Index of the link.

        Returns:
            The heading, counted towards side A; NaN where an angle in between is unknown.
        """
        angles, vee = self.angles(numbers), self.parts[part]
        first, last = vee.wheels[0], vee.wheels[-1]
        aside_m = 0.0
        if self.sides[first] != self.sides[last]:
            span_m = numbers[vee.diameter] if vee.diameter >= 0 else nan
            aside_m = span_m / 2 - self.wheel_radius_m
        turn = self.lean(self.shape(angles, first), vee.wheels, aside_m)
        return self.headings(angles, first)[link] + turn


def known(points: Sequence[Point], wheels: Sequence[int]) -> bool:
    """Return whether the place of every one of the wheels is known."""
    return not any(isnan(points[wheel][0]) for wheel in wheels)
