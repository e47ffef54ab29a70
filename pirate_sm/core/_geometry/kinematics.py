"""Forward kinematics of a chain of wheels and links in its plane, from the joint angles.

The angle of a joint is the heading of the link behind it minus that of the link ahead, both
positive towards side A: a negative angle turns the body ahead towards side A (thesis section 3-2).
An unknown angle is NaN, and so is every position and heading that depends on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import asin, atan2, cos, isnan, nan, sin, sqrt
from typing import NamedTuple

from pirate_sm.core._geometry.space import Place


class Pose(NamedTuple):
    """Position and heading of a link in the plane, m and rad.

    The origin of a link's frame is its front wheel; x points ahead along the link.
    """

    x_m: float
    y_m: float
    heading_rad: float


ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Chain:
    """Wheels joined by rigid links, front to rear.

    Attributes:
        lengths_m: Length of each link; the first one lies between wheels 0 and 1.
        sides: Per wheel the side that it touches while its part is clamped: 1 is A, -1 is B.
    """

    lengths_m: tuple[float, ...]
    sides: tuple[int, ...]

    def headings(
        self, angles: Sequence[float], first: int = 0, heading_rad: float = 0.0
    ) -> list[float]:
        """Return the heading of each link, rad.

        Args:
            angles: Joint angle at each wheel, rad; those of the two end wheels are ignored.
            first: Index of the reference wheel; the last wheel refers to the link ahead of it.
            heading_rad: Heading of the link behind the reference wheel.
        """
        first = min(first, len(self.lengths_m) - 1)
        headings = [heading_rad] * len(self.lengths_m)
        for link in range(first + 1, len(headings)):
            headings[link] = headings[link - 1] + angles[link]
        for link in range(first - 1, -1, -1):
            headings[link] = headings[link + 1] - angles[link + 1]
        return headings

    def places(self, angles: Sequence[float], first: int = 0, pose: Pose = ORIGIN) -> list[Place]:
        """Return the position of each wheel, m, given the pose of the link behind wheel ``first``.

        Args:
            angles: See :meth:`headings`.
            first: See :meth:`headings`.
            pose: Pose of the link behind the reference wheel.
        """
        first = min(first, len(self.lengths_m) - 1)
        steps = [
            (length * cos(heading), length * sin(heading))
            for length, heading in zip(
                self.lengths_m, self.headings(angles, first, pose.heading_rad), strict=True
            )
        ]
        places: list[Place] = [(pose.x_m, pose.y_m)] * (len(steps) + 1)
        for wheel in range(first, len(steps)):
            (x, y), (along, across) = places[wheel], steps[wheel]
            places[wheel + 1] = (x - along, y - across)
        for wheel in range(first - 1, -1, -1):
            (x, y), (along, across) = places[wheel + 1], steps[wheel]
            places[wheel] = (x + along, y + across)
        return places

    def lean(self, places: Sequence[Place], wheels: Sequence[int], aside_m: float) -> float:
        """Return the rotation of the chain that aligns a part with the pipe, rad.

        Args:
            places: Positions of all wheels, m.
            wheels: Wheels of the part; each touches its side of the pipe.
            aside_m: Distance from the pipe's axis of a wheel that touches a side.
        """
        front, rear = wheels[0], wheels[-1]
        along, across = places[front][0] - places[rear][0], places[front][1] - places[rear][1]
        # Not `hypot`, which rounds differently from one language to the next.
        length_m = sqrt(along * along + across * across) or 1.0
        rise = (self.sides[front] - self.sides[rear]) * aside_m / length_m
        if isnan(rise):
            return nan
        return asin(max(-1.0, min(1.0, rise))) - atan2(across, along)


def link_poses(places: Sequence[Place]) -> tuple[Pose, ...]:
    """Return the pose of each link from the positions of the wheels."""
    return tuple(Pose(ax, ay, atan2(ay - by, ax - bx)) for (ax, ay), (bx, by) in pairwise(places))
