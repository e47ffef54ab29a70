"""A chain in space: two parts that are planar each, with a roll joint in the link between them."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2
from typing import NamedTuple

from pirate_sm.core._geometry.plane import turned
from pirate_sm.core._geometry.space import Frame, Place, Vector


class ChainInSpace(NamedTuple):
    """Where a chain is.

    Attributes:
        points: Position of each wheel.
        front: A frame in whose plane the part ahead of the roll joint lies; its origin is anywhere.
        rear: Likewise for the part behind it.
    """

    points: tuple[Vector, ...]
    front: Frame
    rear: Frame


def in_space(
    places: Sequence[Place], plane: Frame, *, wheel: int, link: int, roll_rad: float
) -> ChainInSpace:
    """Return where a chain is whose roll joint is turned.

    Args:
        places: Positions of the wheels if the joint were straight, in the coordinates of ``plane``:
            x ahead, y to its side. NaN is unknown.
        plane: The frame in whose plane one of the two parts lies.
        wheel: A wheel of that part.
        link: Index of the link with the roll joint; -1 without one.
        roll_rad: How far its front half is rolled against its rear half; NaN is unknown.
    """
    points = [plane.point(x, y) for x, y in places]
    if link < 0:
        return ChainInSpace(tuple(points), plane, plane)
    behind = wheel > link
    (x, y), (rear_x, rear_y) = places[link : link + 2]
    heading = atan2(y - rear_y, x - rear_x)
    hinge = plane.turned(heading)._replace(origin=points[link])
    other = hinge.rolled(roll_rad if behind else -roll_rad)
    for each in range(link) if behind else range(link + 2, len(places)):
        along, across = turned((places[each][0] - x, places[each][1] - y), -heading)
        points[each] = other.point(along, across)
    return ChainInSpace(tuple(points), *((other, plane) if behind else (plane, other)))
