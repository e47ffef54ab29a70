"""Where the wheels of a robot are, from its joint angles: forward kinematics of a planar chain.

The plane is that of the simulator: x along the first leg of the pipe, y towards side A. A link's
frame sits at its front wheel, its x axis points ahead along the link. The angle of a joint is the
heading of the link behind it minus that of the link ahead, so that a negative one turns the body
ahead towards side A (as in the profiles; sign of thesis section 3-2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import atan2, cos, isfinite, sin
from typing import NamedTuple

from pirate_sm.model.body import Body


class Pose(NamedTuple):
    """Place and heading of a frame in the plane, m and rad."""

    x_m: float
    y_m: float
    heading_rad: float


ORIGIN = Pose(0.0, 0.0, 0.0)


def bends(body: Body, angles: Mapping[str, float]) -> tuple[float, ...]:
    """The angle at each wheel from the second to the last but one, rad.

    Args:
        body: The chain; a wheel without a driven joint is straight.
        angles: By the name of the joint; an unknown one counts as 0.
    """
    at = {joint.wheel: angles.get(joint.name, 0.0) for joint in body.joints}
    inner = body.wheels[1:-1]
    return tuple(_known(at.get(wheel.name, 0.0)) for wheel in inner)


def _known(angle: float) -> float:
    return angle if isfinite(angle) else 0.0


def links(body: Body, angles: Mapping[str, float], front: Pose = ORIGIN) -> tuple[Pose, ...]:
    """The frame of each link, from the front; ``front`` is that of the first one."""
    found = [front]
    for link, bend in zip(body.links, bends(body, angles), strict=False):
        x, y, heading = found[-1]
        x, y = x - link.length * cos(heading), y - link.length * sin(heading)
        found.append(Pose(x, y, heading + bend))
    return tuple(found)


def wheels(
    body: Body, angles: Mapping[str, float], front: Pose = ORIGIN
) -> tuple[tuple[float, float], ...]:
    """The centre of each wheel, from the front."""
    frames = links(body, angles, front)
    x, y, heading = frames[-1]
    length = body.links[-1].length
    last = (x - length * cos(heading), y - length * sin(heading))
    return (*((each.x_m, each.y_m) for each in frames), last)


def frames_of(places: Sequence[tuple[float, float]]) -> tuple[Pose, ...]:
    """The frame of each link from the places of the wheels, as a simulator knows them."""
    return tuple(Pose(ax, ay, atan2(ay - by, ax - bx)) for (ax, ay), (bx, by) in pairwise(places))
