"""What a synthetic camera shows: the robot at one moment, and the pipe, as plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2
from typing import TypeAlias

from pirate_sm.core.geometry import Place, Route, inner_corner
from pirate_sm.core.geometry import walls as walls_of
from pirate_sm.core.profile import Body

Wall: TypeAlias = tuple[Place, ...]


@dataclass(frozen=True)
class ShownLink:
    """A link of the robot between two wheels; places are in the plane of the setup, m.

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
    walls: tuple[Wall, Wall]
    wheel_radius_m: float
    half_thickness_m: float

    def moved(self, before: ShownScene, share: float) -> ShownScene:
        """Return the scene between an earlier one (``share`` 0) and this one (1)."""
        links = tuple(
            ShownLink(
                now.module,
                between(then.front, now.front, share),
                between(then.rear, now.rear, share),
            )
            for then, now in zip(before.links, self.links, strict=True)
        )
        return ShownScene(links, self.walls, self.wheel_radius_m, self.half_thickness_m)


def scene_in_pipe(wheels: Sequence[Place], body: Body, route: Route) -> ShownScene:
    """Return the scene of a simulated robot.

    Args:
        wheels: Place of each wheel in the plane of the pipe, m, front to rear.
        body: The body of the robot.
        route: The route through its pipe.
    """
    x, y = inner_corner(route)
    side_a, side_b = (tuple((u - x, v - y) for u, v in wall) for wall in walls_of(route))
    places = [(u - x, v - y) for u, v in wheels]
    links = tuple(
        ShownLink(link.module, front, rear)
        for link, (front, rear) in zip(body.links, pairwise(places), strict=True)
    )
    return ShownScene(links, (side_a, side_b), body.wheel_radius, body.body_half_thickness)


def between(one: Place, other: Place, share: float) -> Place:
    """Return the place that is this share of the way from one to the other."""
    return one[0] + share * (other[0] - one[0]), one[1] + share * (other[1] - one[1])
