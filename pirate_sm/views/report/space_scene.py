"""The robot in a network of round pipes over time, for the report's pictures in space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import degrees

from pirate_sm.core.geometry import (
    Frame,
    Place,
    Route,
    RouteJoint,
    outlines,
    part_normals,
    plain_tubes,
    seen_in,
    upright,
    walls_in_space,
)
from pirate_sm.core.profile import Profile
from pirate_sm.core.simulation import InSpace
from pirate_sm.views.report.space_contents import NamedPoint, SideSeen, SpaceScene, WayPoint

_WAY_M = 0.05
"""The most between two points of the centre line."""

_FLATTER = 0.5
"""A network that is deeper than wide by this factor is drawn from its other side."""


def space_scene(
    points: Sequence[Sequence[Place]], spaces: Sequence[InSpace], profile: Profile, route: Route
) -> SpaceScene:
    """Return the scene.

    Args:
        points: At each time the position of each wheel in the plane of the drawing, m.
        spaces: What these leave out.
        profile: The robot's profile.
        route: The route through the pipes.
    """
    frame = upright(route.up)
    drawn = [
        tuple((x, y, z) for (x, y), z in zip(wheels, space.z_m, strict=True))
        for wheels, space in zip(points, spaces, strict=True)
    ]
    rear = profile.body.first_behind_roll
    planes = [
        part_normals(route, wheels, rear, space.rolls_rad[1:])
        for wheels, space in zip(drawn, spaces, strict=True)
    ]
    return SpaceScene(
        poses=[tuple(seen_in(frame, point) for point in wheels) for wheels in drawn],
        normals=[(seen_in(frame, front), seen_in(frame, behind)) for front, behind in planes],
        rear=rear,
        wheel_width_m=profile.body.wheel_width,
        walls=tuple(
            tuple(tuple(seen_in(frame, point) for point in ring) for ring in rings)
            for rings in walls_in_space(route.network, route.placement)
        ),
        sides=_sides(route, frame),
        way=tuple(_way(route, frame)),
        names=tuple(_names(route, frame)),
    )


def _sides(route: Route, frame: Frame) -> tuple[SideSeen, ...]:
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
    views = (("From above", (0, 1)), ("From the side", (level, 2)))
    return tuple(SideSeen(name, axes, outlines(tubes, axes)) for name, axes in views)


def _way(route: Route, frame: Frame) -> Iterator[WayPoint]:
    for piece in route.pieces:
        steps = 1 if piece.arc is None and piece.ends_with_m == piece.diameter_m else 0
        steps = steps or max(2, round(piece.length_m / _WAY_M))
        for number in range(steps + 1):
            arc_m = piece.arc_m + piece.length_m * number / steps
            point = seen_in(frame, piece.point(arc_m))
            yield WayPoint(point, piece.diameter_at(arc_m))


def _names(route: Route, frame: Frame) -> Iterator[NamedPoint]:
    yield NamedPoint("begins", seen_in(frame, route.frame_at(0.0).origin))
    for joint in route.joints:
        yield NamedPoint(joint_name(joint), seen_in(frame, route.frame_at(joint.arc_m).origin))
    yield NamedPoint("ends", seen_in(frame, route.frame_at(route.length_m).origin))


def joint_name(joint: RouteJoint) -> str:
    """Return the label of a joint: ``mitre 90°``, or a tee by its name."""
    if joint.junction:
        return joint.junction
    return f"{joint.kind} {degrees(joint.turn_rad):z.0f}°" if joint.turn_rad else joint.kind
