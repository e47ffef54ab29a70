"""The contents of a report's pictures in space, as plain values.

Coordinates are m: x is level, ahead in the first run as seen from above; y is on its left; z is up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from pirate_sm.core.geometry import Outline, Place, Rings, Vector


class FlatView(NamedTuple):
    """The robot in its pipe as it is seen along one axis.

    Attributes:
        name: What is seen, as ``From above``; empty for the plane of a planar pipe.
        poses: The position of each wheel, front to rear, at each time.
        walls: Corners of the two walls of a planar pipe.
        outlines: Convex areas that together are the inside of the pipes.
    """

    name: str
    poses: Sequence[Sequence[Place]]
    walls: tuple[tuple[Place, ...], ...] = ()
    outlines: tuple[Outline, ...] = ()


class SideSeen(NamedTuple):
    """A direction from which a network is drawn.

    Attributes:
        name: What is seen.
        axes: The axis to the right and the axis up.
        outlines: As in :class:`FlatView`.
    """

    name: str
    axes: tuple[int, int]
    outlines: tuple[Outline, ...]


class WayPoint(NamedTuple):
    """A point of the route's centre line, with the inner diameter there."""

    point: Vector
    diameter_m: float


class NamedPoint(NamedTuple):
    """A joint or an end, with its name."""

    name: str
    point: Vector


@dataclass(frozen=True)
class SpaceScene:
    """The robot in a network of round pipes.

    Attributes:
        poses: At each time the position of each wheel, front to rear.
        normals: At each time the unit normals of the planes of the front and of the rear part.
        rear: Index of the first wheel behind the roll joint.
        wheel_width_m: Width of a wheel.
        walls: The walls of all pipes.
        sides: From where the network is drawn.
        way: The centre line of the route.
        names: Joints and ends.
    """

    poses: Sequence[Sequence[Vector]]
    normals: Sequence[tuple[Vector, Vector]]
    rear: int
    wheel_width_m: float
    walls: tuple[Rings, ...]
    sides: tuple[SideSeen, ...]
    way: tuple[WayPoint, ...]
    names: tuple[NamedPoint, ...]

    @property
    def views(self) -> tuple[FlatView, ...]:
        """Return what is seen from each side."""
        return tuple(
            FlatView(
                name,
                [[(point[one], point[other]) for point in pose] for pose in self.poses],
                outlines=outlines,
            )
            for name, (one, other), outlines in self.sides
        )
