"""How a network of pipes is seen: from which sides, along which line, with which names.

Coordinates are m: x is level, ahead in the first run as seen from above; y is on its left; z is up.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees
from typing import NamedTuple

from pirate_sm.core.geometry import Frame, Route, RouteJoint, Vector
from pirate_sm.running.recording.viewers.pipe_walls import Outline, outlines, plain_tubes, seen_in

_WAY_M = 0.05
"""The most between two points of the centre line."""

_FLATTER = 0.5
"""A network that is deeper than wide by this factor is drawn from its other side."""


class SideSeen(NamedTuple):
    """A direction from which a network is drawn.

    Attributes:
        name: What is seen.
        axes: The axis to the right and the axis up.
        outlines: Convex areas that together are the inside of the pipes.
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


def sides(route: Route, frame: Frame) -> tuple[SideSeen, ...]:
    """Return the directions that show how the route turns: from above, from the side, or both."""
    tubes = [
        tuple(tuple(seen_in(frame, point) for point in ring) for ring in rings)
        for rings in plain_tubes(route.placement)
    ]
    wide_m, deep_m = (
        max(values) - min(values)
        for values in (
            [point[axis] for rings in tubes for ring in rings for point in ring] for axis in (0, 1)
        )
    )
    level = 0 if wide_m >= _FLATTER * deep_m else 1
    views = (("From above", (0, 1), 2), ("From the side", (level, 2), 1 - level))
    across = [axis for _, _, axis in views if _is_flat(route, frame, axis)]
    return tuple(
        SideSeen(name, axes, outlines(tubes, axes))
        for name, axes, axis in views
        # Of a flat route one picture shows all, and the other one its edge.
        if len(across) != 1 or axis in across
    )


def _is_flat(route: Route, frame: Frame, axis: int) -> bool:
    """Return whether the centre line turns nowhere towards this axis."""
    way = [each.point[axis] for each in centre_line(route, frame)]
    return max(way) - min(way) < min(piece.diameter_m for piece in route.pieces) / 2


def centre_line(route: Route, frame: Frame) -> Iterator[WayPoint]:
    """Yield points of the centre line of the route."""
    for piece in route.pieces:
        steps = 1 if piece.arc is None and piece.ends_with_m == piece.diameter_m else 0
        steps = steps or max(2, round(piece.length_m / _WAY_M))
        for number in range(steps + 1):
            arc_m = piece.arc_m + piece.length_m * number / steps
            point = seen_in(frame, piece.point(arc_m))
            yield WayPoint(point, piece.diameter_at(arc_m))


def named_points(route: Route, frame: Frame) -> Iterator[NamedPoint]:
    """Yield the beginning, the joints and the end of the route."""
    yield NamedPoint("begins", seen_in(frame, route.frame_at(0.0).origin))
    for joint in route.joints:
        yield NamedPoint(joint_name(joint), seen_in(frame, route.frame_at(joint.arc_m).origin))
    yield NamedPoint("ends", seen_in(frame, route.frame_at(route.length_m).origin))


def joint_name(joint: RouteJoint) -> str:
    """Return the label of a joint: ``mitre 90°``, or a tee by its name."""
    if joint.junction:
        return joint.junction
    return f"{joint.kind} {degrees(joint.turn_rad):z.0f}°" if joint.turn_rad else joint.kind
