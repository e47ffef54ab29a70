"""The route through a round pipe as a plane: along it, and across it in the plane of each part.

Where side A points is given as seen looking ahead along the pipe: 0 is to the right, 90 deg up.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, isnan, pi
from typing import NamedTuple

from pirate_sm.geometry.joints import Joint
from pirate_sm.geometry.plane import Walls
from pirate_sm.geometry.route import Route
from pirate_sm.geometry.space import Place, Vector
from pirate_sm.geometry.views import clock_rad, unrolled, unrolled_walls
from pirate_sm.model.true_position import Truth
from pirate_sm.showing.snapshot import Scene

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


def unroll(scene: Scene, truth: Truth) -> Unrolled | None:
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


def _told(route: Route, joint: Joint) -> str:
    """Return what a joint is and where it leads; for a tee straight on, where its opening is."""
    if isnan(joint.towards_rad):
        return joint.kind
    towards = arrow(clock_rad(route, joint.arc_m - joint.before_m, joint.towards_rad))
    return f"{joint.kind} {towards}" if joint.turn_rad else f"{joint.kind} {towards} past"
