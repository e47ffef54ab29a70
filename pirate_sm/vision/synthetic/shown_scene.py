"""What a synthetic camera shows: the robot at one moment, and the pipe, as plain data."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2
from typing import TypeAlias

Place: TypeAlias = tuple[float, float]
"""x along the first leg and y to side A from the inner corner of the bend, m."""


@dataclass(frozen=True)
class ShownLink:
    """A link of the robot between two wheels.

    Attributes:
        module: Name of its module, as in the camera's file.
        front: Place of the wheel ahead.
        rear: Place of the wheel behind.
    """

    module: str
    front: Place
    rear: Place

    @property
    def middle(self) -> Place:
        """Return the place of its middle, where its tag is."""
        return 0.5 * (self.front[0] + self.rear[0]), 0.5 * (self.front[1] + self.rear[1])

    @property
    def heading_rad(self) -> float:
        """Return the direction in which it points ahead."""
        return atan2(self.front[1] - self.rear[1], self.front[0] - self.rear[0])


@dataclass(frozen=True)
class ShownScene:
    """The robot at one moment, and what does not move.

    Attributes:
        links: Its links, front to rear.
        walls: Corners of the wall on side A and of that on side B.
        wheel_radius_m: Radius of its wheels.
        half_thickness_m: Distance from the axis of a link to its surface.
    """

    links: tuple[ShownLink, ...]
    walls: tuple[tuple[Place, ...], tuple[Place, ...]]
    wheel_radius_m: float
    half_thickness_m: float

    def moved(self, before: ShownScene, share: float) -> ShownScene:
        """Return the scene between an earlier one (``share`` 0) and this one (1)."""
        links = tuple(
            ShownLink(
                now.module,
                _between(then.front, now.front, share),
                _between(then.rear, now.rear, share),
            )
            for then, now in zip(before.links, self.links, strict=True)
        )
        return ShownScene(links, self.walls, self.wheel_radius_m, self.half_thickness_m)


def _between(then: Place, now: Place, share: float) -> Place:
    return (
        then[0] + share * (now[0] - then[0]),
        then[1] + share * (now[1] - then[1]),
    )
