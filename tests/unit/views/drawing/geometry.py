"""What lies on what in a layout."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from pirate_sm.views.drawing.svg.ranks import EdgeRoute, Point, Size

Rectangle = tuple[float, float, float, float]
SLACK = 0.01


def rectangle(corner: Point, size: Size) -> Rectangle:
    return corner[0], corner[1], corner[0] + size.width, corner[1] + size.height


def overlap(one: Rectangle, other: Rectangle) -> bool:
    return (
        one[0] < other[2] - SLACK
        and other[0] < one[2] - SLACK
        and one[1] < other[3] - SLACK
        and other[1] < one[3] - SLACK
    )


def inside(point: Point, area: Rectangle) -> bool:
    return overlap((*point, *point), (area[0] + 0.1, area[1] + 0.1, area[2] - 0.1, area[3] - 0.1))


def along(route: EdgeRoute, pieces: int = 24) -> Iterator[Point]:
    """Points of the route as it is drawn: its swings are cubics with vertical ends."""
    if route.loop:
        yield from route.points
        return
    for (x, y), (to_x, to_y) in pairwise(route.points):
        for piece in range(pieces + 1):
            t = piece / pieces
            yield (
                x + (to_x - x) * (3 * t**2 - 2 * t**3),
                y + (to_y - y) * (1.5 * t - 1.5 * t**2 + t**3),
            )
