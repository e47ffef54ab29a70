"""Where to draw the wheels: where they are known to be, else as the joints say, else straight."""

from __future__ import annotations

from itertools import pairwise
from math import cos, inf, isnan, sin
from typing import NamedTuple

from pirate_sm.engine.robot.robot_state import confirmed_parts
from pirate_sm.showing.snapshot import Snapshot

Place = tuple[float, float]

SIDES = "AB"


class Pose(NamedTuple):
    """The robot as it is drawn.

    Attributes:
        wheels: Places, m, from the front.
        walls: Corners of the walls; none where the pipe is not known.
        touching: Per wheel the wall that it touches, 0 for A and 1 for B; -1 for none.
        held: Per link whether it belongs to a part that is held.
        origin: In words where this comes from; empty where it is known.
    """

    wheels: tuple[Place, ...]
    walls: tuple[tuple[Place, ...], ...]
    touching: tuple[int, ...]
    held: tuple[bool, ...]
    origin: str


def pose_of(snapshot: Snapshot) -> Pose:
    """How the robot is to be drawn."""
    anatomy, state, truth = snapshot.scene.anatomy, snapshot.state, snapshot.truth
    robot = snapshot.scene.robot
    held: frozenset[int] = frozenset()
    sure: frozenset[int] = frozenset()
    if state is not None:
        held = robot.held[state.robot.configuration]
        sure = confirmed_parts(robot, state.robot)
    parts = anatomy.wheel_parts
    links = tuple(
        parts[link] == parts[link + 1] and parts[link] in held
        for link in range(len(anatomy.lengths_m))
    )
    by_part = tuple(
        side if part in sure else -1 for part, side in zip(parts, anatomy.sides, strict=True)
    )
    if truth is None:
        wheels, seen = _chain(snapshot)
        origin = "drawn from joint angles" if seen else "drawn straight: no sensor speaks"
        return Pose(wheels, (), by_part, links, origin)
    if not truth.touching:
        origin = "reckoned from odometry" if snapshot.reckoned else ""
        return Pose(truth.wheels, truth.walls, by_part, links, origin)
    touching = tuple(
        _nearest(place, truth.walls) if touches else -1
        for place, touches in zip(truth.wheels, truth.touching, strict=True)
    )
    return Pose(truth.wheels, truth.walls, touching, links, "")


def _chain(snapshot: Snapshot) -> tuple[tuple[Place, ...], bool]:
    """The chain with its front at the right, and whether any joint has an angle.

    A joint's angle is the heading of the link ahead less that of the link behind, counted away
    from side A, which is up.
    """
    anatomy, seen = snapshot.scene.anatomy, False
    x = y = heading = 0.0
    places = [(x, y)]
    for wheel, length_m in enumerate(anatomy.lengths_m):
        angle = snapshot.signals.get(anatomy.joint_at[wheel], 0.0)
        if not isnan(angle):
            heading += angle
            seen = seen or bool(anatomy.joint_at[wheel])
        x, y = x - length_m * cos(heading), y - length_m * sin(heading)
        places.append((x, y))
    return tuple(places), seen


def _nearest(place: Place, walls: tuple[tuple[Place, ...], ...]) -> int:
    found, least = -1, inf
    for side, corners in enumerate(walls):
        for one, other in pairwise(corners):
            away = beside(place, one, other)[0]
            if away < least:
                found, least = side, away
    return found


def beside(place: Place, one: Place, other: Place) -> tuple[float, Place]:
    """How far a place is from a piece of wall, and the point of it that is nearest."""
    dx, dy = other[0] - one[0], other[1] - one[1]
    length = dx * dx + dy * dy
    share = ((place[0] - one[0]) * dx + (place[1] - one[1]) * dy) / length if length else 0.0
    share = min(1.0, max(0.0, share))
    near = one[0] + share * dx, one[1] + share * dy
    return ((place[0] - near[0]) ** 2 + (place[1] - near[1]) ** 2) ** 0.5, near


def contact(pose: Pose, wheel: int) -> Place | None:
    """The point of the wall that a wheel touches; None where it touches none."""
    side = pose.touching[wheel]
    if side < 0 or side >= len(pose.walls):
        return None
    corners = pose.walls[side]
    pairs = pairwise(corners)
    return min(beside(pose.wheels[wheel], *pair) for pair in pairs)[1]
