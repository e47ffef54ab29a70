"""The robot as views draw it: by known places of its wheels, else by its joints, else straight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import degrees, inf, isnan, pi
from typing import NamedTuple

from pirate_sm.core.geometry import (
    Place,
    Route,
    RouteJoint,
    Vector,
    Walls,
    clock_rad,
    nearest_on,
    unrolled,
    unrolled_walls,
)
from pirate_sm.core.robot import confirmed_parts
from pirate_sm.core.simulation import Truth
from pirate_sm.views.showing.snapshot import MissionScene, Snapshot
from pirate_sm.views.showing.text_styles import ago

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


_CORNER = 2.0
"""The outer corner of a mitre of 120 deg is this many radii away from where the axes cross."""

ARROWS = "→↗↑↖←↙↓↘"
"""The directions across a pipe, looking ahead, counter-clockwise from the right."""


class JointMark(NamedTuple):
    """A joint on the unrolled route.

    Attributes:
        text: What it is, and where it leads.
        at: Where the axes cross.
        from_m: Where the walls are no longer those of a plain pipe.
        to_m: From where on they are again.
        half_m: Half the inner diameter there.
    """

    text: str
    at: float
    from_m: float
    to_m: float
    half_m: float


class Dial(NamedTuple):
    """Where side A of a part points.

    Attributes:
        part: Name of the part.
        angle_rad: The direction across the pipe, looking ahead; 0 right, 90 deg up.
    """

    part: str
    angle_rad: float

    @property
    def text(self) -> str:
        """Return the direction in words, as ``front A ↑ 90°``."""
        turned = round(degrees(self.angle_rad)) % 360
        return f"{self.part} A {arrow(self.angle_rad)} {turned - 360 * (turned > 180)}°"


class Unrolled(NamedTuple):
    """A robot on its unrolled route.

    Attributes:
        wheels: Position of each wheel: along the route, and to side A in the plane of its part.
        walls: The walls on side A and on side B.
        joints: The joints of the route.
        dials: Where side A of each part points.
        place: In words where the first wheel is.
    """

    wheels: tuple[Place, ...]
    walls: Walls
    joints: tuple[JointMark, ...]
    dials: tuple[Dial, ...]
    place: str


def arrow(angle_rad: float) -> str:
    """Return the arrow for a direction across the pipe."""
    return ARROWS[round(angle_rad / (pi / 4)) % len(ARROWS)]


def unroll(scene: MissionScene, truth: Truth) -> Unrolled | None:
    """Return a robot on its unrolled route; None where its place in space is not known."""
    route = scene.route
    if route is None or route.section == "bars" or not truth.z_m or not truth.rolls_rad:
        return None
    parts = scene.anatomy.wheel_parts
    rolls = truth.rolls_rad[1:]
    of_wheel = [rolls[min(part, len(rolls) - 1)] for part in parts]
    wheels = tuple(
        unrolled(route, point, roll) for point, roll in zip(truth.points, of_wheel, strict=True)
    )
    dials = []
    for part, (name, roll) in enumerate(zip(scene.robot.parts, rolls, strict=False)):
        arcs = [wheel[0] for wheel, own in zip(wheels, parts, strict=True) if own == part]
        dials.append(Dial(name, clock_rad(route, sum(arcs) / len(arcs), roll)))
    first_m = wheels[0][0]
    place = f"{route.piece_at(first_m).run}, {first_m:.2f} m"
    if any(_off(route, point) for point in truth.points):
        place = "not on its route"
    return Unrolled(wheels, unrolled_walls(route), tuple(_marks(route)), tuple(dials), place)


def _off(route: Route, point: Vector) -> bool:
    """Return whether a point is outside the route, as in an arm of a tee that it passes."""
    arc_m, away_m = route.nearest(point)
    return away_m > _CORNER * route.diameter_at(arc_m) / 2


def _marks(route: Route) -> Iterator[JointMark]:
    for joint in route.joints:
        half_m = route.diameter_at(joint.arc_m) / 2
        ends = joint.arc_m - joint.before_m, joint.arc_m + joint.behind_m
        yield JointMark(_told(route, joint), joint.arc_m, *ends, half_m)


def _told(route: Route, joint: RouteJoint) -> str:
    """Return what a joint is and where it leads; for a tee straight on, where its opening is."""
    if isnan(joint.towards_rad):
        return joint.kind
    towards = arrow(clock_rad(route, joint.arc_m - joint.before_m, joint.towards_rad))
    return f"{joint.kind} {towards}" if joint.turn_rad else f"{joint.kind} {towards} past"
