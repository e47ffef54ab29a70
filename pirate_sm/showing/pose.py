"""The robot as views draw it: by known places of its wheels, else by its joints, else straight."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf, isnan
from typing import NamedTuple

from pirate_sm.engine.robot.robot_state import confirmed_parts
from pirate_sm.geometry.plane import nearest_on
from pirate_sm.geometry.space import Place
from pirate_sm.model.true_position import Truth
from pirate_sm.showing.snapshot import Snapshot
from pirate_sm.showing.text_styles import ago
from pirate_sm.showing.unrolled import Dial, JointMark, unroll

SIDES = "AB~"
"""The walls; the last one is beside the plane in which the part of a wheel lies."""

_STRAIGHT = "drawn straight: no sensor speaks"

_BESIDE_M = 0.004
"""A wheel farther from both walls, in its part's plane, touches the pipe beside that plane."""


class RobotPose(NamedTuple):
    """The robot as it is drawn.

    Attributes:
        wheels: Places, m, from the front.
        walls: Corners of the walls; none where the pipe is not known.
        touching: Per wheel the wall that it touches, 0 for A and 1 for B, 2 beside the plane of its
            part; -1 for none.
        held: Per link whether it belongs to a part that is held.
        origin: In words where this comes from; empty where it is known.
        joints: The joints of an unrolled route.
        dials: Where side A of each part points, in a round pipe.
        place: In words where on its route the first wheel is; empty unless that is unrolled.
        live: Whether this is the present moment, not what was last heard of the robot.
    """

    wheels: tuple[Place, ...]
    walls: tuple[tuple[Place, ...], ...]
    touching: tuple[int, ...]
    held: tuple[bool, ...]
    origin: str
    joints: tuple[JointMark, ...] = ()
    dials: tuple[Dial, ...] = ()
    place: str = ""
    live: bool = True


def pose_of(snapshot: Snapshot) -> RobotPose:
    """Return the robot as it is to be drawn; if it is not heard, without what it touches."""
    pose = _last_pose(snapshot)
    if snapshot.live:
        return pose
    age = f" {ago(snapshot.unheard_s)} ago" if snapshot.unheard_s else ""
    origin = pose.origin if pose.origin == _STRAIGHT else f"as last heard{age}"
    return pose._replace(touching=(-1,) * len(pose.touching), origin=origin, live=False)


def _last_pose(snapshot: Snapshot) -> RobotPose:
    truth, (links, by_part) = snapshot.truth, _held(snapshot)
    # A place in the plane of the drawing says nothing where the pipe does not lie in it.
    if truth is None or not (truth.walls or truth.z_m or snapshot.scene.route is None):
        wheels, seen = _chain(snapshot)
        origin = "drawn from joint angles" if seen else _STRAIGHT
        return RobotPose(wheels, (), by_part, links, origin)
    unrolled = unroll(snapshot.scene, truth)
    if unrolled is not None:
        touching = _touching(unrolled.wheels, unrolled.walls, truth, _BESIDE_M)
        wheels, walls, joints, dials, place = unrolled
        return RobotPose(wheels, walls, touching or by_part, links, "", joints, dials, place)
    touching = _touching(truth.wheels, truth.walls, truth, inf)
    origin = "reckoned from odometry" if snapshot.reckoned and not touching else ""
    return RobotPose(truth.wheels, truth.walls, touching or by_part, links, origin)


def _held(snapshot: Snapshot) -> tuple[tuple[bool, ...], tuple[int, ...]]:
    """Return for each link whether its part is held, and for each wheel the wall by command."""
    robot, state = snapshot.scene.robot, snapshot.state
    held: frozenset[int] = frozenset()
    sure: frozenset[int] = frozenset()
    if state is not None:
        held = robot.held[state.robot.configuration]
        sure = confirmed_parts(robot, state.robot)
    parts = snapshot.scene.anatomy.wheel_parts
    links = tuple(one == other and one in held for one, other in pairwise(parts))
    by_part = tuple(
        int(side < 0) if part in sure else -1
        for part, side in zip(parts, robot.body.sides, strict=True)
    )
    return links, by_part


def _touching(
    wheels: Sequence[Place], walls: Sequence[Sequence[Place]], truth: Truth, beside_m: float
) -> tuple[int, ...]:
    """Return the wall that each wheel touches; empty if that is unknown.

    Args:
        wheels: The wheels as they are drawn.
        walls: The walls as they are drawn.
        truth: What is known of the robot.
        beside_m: A wheel that is farther from both walls touches beside the plane.
    """
    found = []
    for place, touches in zip(wheels, truth.touching, strict=False):
        away, side = min(
            ((nearest_on(wall, place)[0], n) for n, wall in enumerate(walls)), default=(inf, 2)
        )
        beside = away > truth.wheel_radius_m + beside_m
        found.append(-1 if not touches else 2 if beside else side)
    return tuple(found)


def _chain(snapshot: Snapshot) -> tuple[tuple[Place, ...], bool]:
    """Return the chain with its front at the right, and whether any joint has an angle."""
    joints = snapshot.scene.anatomy.joint_at
    angles = [snapshot.signals.get(joint, 0.0) for joint in joints]
    seen = any(joint and not isnan(angle) for joint, angle in zip(joints, angles, strict=True))
    known = [0.0 if isnan(angle) else angle for angle in angles]
    return tuple(snapshot.scene.robot.body.places(known)), seen


def contact(pose: RobotPose, wheel: int) -> Place | None:
    """Return the point of the wall that a wheel touches; None where it touches none."""
    side = pose.touching[wheel]
    if side < 0 or side >= len(pose.walls):
        return None
    return nearest_on(pose.walls[side], pose.wheels[wheel])[1]
