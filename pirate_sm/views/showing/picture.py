"""The robot in its pipe, to scale, in braille dots; every meaning has a shape as well as a colour.

It is placed by known places of its wheels, else by its joints, else straight. Walls are lines,
their contact with a wheel is a thick piece; a wheel that touches is a full disc with its number,
one that does not is a ring; a part that is held is drawn full, one that is not as an outline; a
light is a fan of rays. A robot that is not heard is dashed, as it was last heard.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import atan2, cos, degrees, dist, floor, hypot, inf, isnan, log, pi, sin
from typing import NamedTuple

from pirate_sm.core.events import Truth
from pirate_sm.core.geometry import Place, Route, RouteJoint, Vector, Walls
from pirate_sm.core.robot import confirmed_parts
from pirate_sm.running.recording.viewers.pipe_walls import clock_rad, unrolled, unrolled_walls
from pirate_sm.views.drawing.canvas import ACROSS, DOWN, Canvas
from pirate_sm.views.showing.robot_anatomy import Anatomy
from pirate_sm.views.showing.roles import ACCENT, GOOD, MUTED, WARN
from pirate_sm.views.showing.roles import ON_A_TERMINAL as ROLES
from pirate_sm.views.showing.snapshot import MissionScene, Snapshot
from pirate_sm.views.showing.text_styles import ago

# --- where the parts are ------------------------------------------------------------------------


SIDES = "AB~"
"""The walls; the last one is next to the plane of a wheel's part."""

_STRAIGHT = "drawn straight: no sensor speaks"

_BESIDE_PLANE_M = 0.004
"""A wheel farther from both walls, in its part's plane, touches the pipe next to that plane."""


class RobotPose(NamedTuple):
    """The robot as it is drawn.

    Attributes:
        wheels: Places, m, from the front.
        walls: Corners of the walls; none where the pipe is not known.
        touching: Per wheel the wall that it touches, 0 for A and 1 for B, 2 next to its part's
            plane; -1 for none.
        held: Per link whether it belongs to a part that is held.
        origin: In words where this comes from; empty where it is known.
        joints: The joints of an unrolled route.
        dials: Where side A of each part points, in a round pipe.
        place: In words where on its route the first wheel is; empty unless that is unrolled.
        live: Whether this is the current moment, not what was last heard of the robot.
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
        touching = _touching(unrolled.wheels, unrolled.walls, truth, _BESIDE_PLANE_M)
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
        beside_m: A wheel that is farther from both walls touches next to the plane.
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


def nearest_on(line: Sequence[Place], place: Place) -> tuple[float, Place]:
    """Return the distance of a point from a polyline, and the nearest point on it."""
    return min(_nearest(one, other, place) for one, other in pairwise(line))


def _nearest(one: Place, other: Place, place: Place) -> tuple[float, Place]:
    dx, dy = other[0] - one[0], other[1] - one[1]
    length = dx * dx + dy * dy
    share = ((place[0] - one[0]) * dx + (place[1] - one[1]) * dy) / length if length else 0.0
    share = min(1.0, max(0.0, share))
    near = one[0] + share * dx, one[1] + share * dy
    return ((place[0] - near[0]) ** 2 + (place[1] - near[1]) ** 2) ** 0.5, near


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


# --- the picture --------------------------------------------------------------------------------


WALL, TOUCH, BODY, HELD = "wall", "touch", "body", "held"
WHEEL, FREE, LIGHT, NOTE = "wheel", "free", "light", "note"

ON_A_TERMINAL: Mapping[str, str] = {
    WALL: ROLES[MUTED],
    TOUCH: ROLES[WARN],
    BODY: ROLES[MUTED],
    HELD: ROLES[ACCENT],
    WHEEL: f"bold {ROLES[GOOD]}",
    FREE: "default",
    LIGHT: ROLES[WARN],
    NOTE: ROLES[MUTED],
}
"""How each of them looks in the colours that every terminal has."""

_ROOM = 1.18
_STEP = 1.12
"""The scale goes in steps, so that the picture does not breathe while the robot bends."""

_DOTTED = 3
"""Dots from one to the next of a dotted line."""

_DIAL = 6
"""Radius of a dial, in dots."""

_DIALS_FROM = 15 * DOWN
"""In a picture that is less high, directions are written and no dials are drawn."""

_BAR_M = 0.1
_BESIDE_M = 0.018


def draw(snapshot: Snapshot, columns: int, rows: int) -> Canvas:
    """Return the picture in so many characters."""
    canvas = Canvas(columns, rows)
    if columns >= 10 and rows >= 4:
        pose = pose_of(snapshot)
        drawing = _Drawing(canvas, pose, snapshot.scene.anatomy)
        drawing.walls()
        drawing.joints()
        canvas.dashed = not pose.live
        drawing.lights(_lit(snapshot) if pose.live else set())
        drawing.body()
        drawing.wheels()
        drawing.notes(pose.origin or pose.place)
        drawing.dials()
    return canvas


def _lit(snapshot: Snapshot) -> set[bool]:
    """Return which ends have a light that is on: True for the front."""
    state = snapshot.state
    if state is None:
        return set()
    values = state.robot.values
    return {forward for slot, forward in snapshot.scene.anatomy.lights if values[slot] > 0}


class _Drawing:
    """Puts one pose on a canvas."""

    def __init__(self, canvas: Canvas, pose: RobotPose, anatomy: Anatomy) -> None:
        self._canvas = canvas
        self._pose = pose
        self._radius_m = anatomy.wheel_radius_m
        self._thick_m = anatomy.half_thickness_m
        xs, ys = zip(*pose.wheels, strict=True)
        margin_m = 2.2 * self._radius_m
        wide_m = (max(xs) - min(xs) + 2 * margin_m) * _ROOM
        high_m = (max(ys) - min(ys) + 2 * margin_m) * _ROOM
        scale = min(canvas.width / wide_m, canvas.height / high_m)
        self._scale: float = _STEP ** floor(log(scale) / log(_STEP))
        self._left = (min(xs) + max(xs)) / 2 - canvas.width / self._scale / 2
        self._top = (min(ys) + max(ys)) / 2 + canvas.height / self._scale / 2

    def _at(self, place: Place) -> Place:
        return (place[0] - self._left) * self._scale, (self._top - place[1]) * self._scale

    def walls(self) -> None:
        """Draw the walls with their letters."""
        for side, wall in enumerate(self._pose.walls):
            for one, other in pairwise(wall):
                self._canvas.line(*self._at(one), *self._at(other), WALL)
            self._name_wall(side, wall)

    def _name_wall(self, side: int, wall: tuple[Place, ...]) -> None:
        """Write a wall's letter outside the pipe, next to the piece nearest the robot's middle."""
        wheels = self._pose.wheels
        middle = len(wheels) // 2
        (x0, y0), (x1, y1) = wheels[middle - 1], wheels[middle]
        x, y = (x0 + x1) / 2, (y0 + y1) / 2
        one, other = min(
            pairwise(wall), key=lambda ends: dist((x, y), ends[0]) + dist((x, y), ends[1])
        )
        length = dist(one, other) or 1.0
        tx, ty = (other[0] - one[0]) / length, (other[1] - one[1]) / length
        share = (x - one[0]) * tx + (y - one[1]) * ty
        foot = one[0] + share * tx, one[1] + share * ty
        outward = 1 if side == 0 else -1
        place = foot[0] - outward * ty * _BESIDE_M, foot[1] + outward * tx * _BESIDE_M
        self._canvas.write(*self._at(place), SIDES[side], NOTE)

    def joints(self) -> None:
        """Draw dotted lines across an unrolled pipe where a joint is, and write what it is."""
        for joint in self._pose.joints:
            for at in {joint.from_m, joint.to_m}:
                x, y = self._at((at, joint.half_m))
                _, low = self._at((at, -joint.half_m))
                for row in range(floor(y), floor(low), _DOTTED):
                    self._canvas.dot(x, row, NOTE)
            x, y = self._at((joint.at, joint.half_m))
            if 0 <= x < self._canvas.width:
                wide = ACROSS * len(joint.text)
                left = max(0.0, min(x - wide / 2, self._canvas.width - wide))
                self._canvas.write(left, y - DOWN, joint.text, NOTE)

    def dials(self) -> None:
        """Draw where side A of each part points, looking ahead along the pipe."""
        canvas, dials = self._canvas, self._pose.dials
        wide = max((len(dial.text) for dial in dials), default=0) * ACROSS
        for row, dial in enumerate(dials):
            canvas.write(canvas.width - wide, row * DOWN, dial.text, NOTE)
        if canvas.height < _DIALS_FROM or canvas.width < 3 * wide:
            return
        for place, dial in enumerate(reversed(dials)):
            x, y = canvas.width - wide - (2 * place + 1) * (_DIAL + ACROSS), _DIAL
            tip = x + _DIAL * cos(dial.angle_rad), y - _DIAL * sin(dial.angle_rad)
            canvas.erase(x, y, _DIAL)
            canvas.circle(x, y, _DIAL, NOTE)
            canvas.line(x, y, *tip, HELD)
            canvas.write(x, y, dial.part[:1], NOTE)

    def body(self) -> None:
        """Draw the links: full where they are held, an outline where they are not."""
        for (one, other), held in zip(pairwise(self._pose.wheels), self._pose.held, strict=True):
            (x0, y0), (x1, y1) = self._at(one), self._at(other)
            length = hypot(x1 - x0, y1 - y0) or 1.0
            nx, ny = -(y1 - y0) / length, (x1 - x0) / length
            half = self._thick_m * self._scale * 0.8
            offsets = [-half, half] if half >= 1.0 else [0.0]
            full = held and self._pose.live
            if full:
                count = max(1, round(2 * half))
                offsets = [-half + 2 * half * n / count for n in range(count + 1)]
            for off in offsets:
                ends = (x0 + nx * off, y0 + ny * off, x1 + nx * off, y1 + ny * off)
                self._canvas.line(*ends, HELD if full else BODY)

    def wheels(self) -> None:
        """Draw the wheels with their numbers, and where they touch."""
        radius = self._radius_m * self._scale
        for number, place in enumerate(self._pose.wheels):
            x, y = self._at(place)
            touches = self._pose.touching[number] >= 0
            if touches:
                self._canvas.disc(x, y, radius, WHEEL)
            else:
                self._canvas.erase(x, y, radius)
                self._canvas.circle(x, y, radius, FREE if self._pose.live else BODY)
            self._touch(number)
            if radius >= 3:
                style = WHEEL if touches else FREE if self._pose.live else BODY
                self._canvas.write(x, y, str(number + 1), style)

    def _touch(self, number: int) -> None:
        point = contact(self._pose, number)
        if point is None:
            return
        (wx, wy), (px, py) = self._pose.wheels[number], point
        away = hypot(px - wx, py - wy) or 1.0
        ox, oy = (px - wx) / away, -(py - wy) / away  # outward, in dots
        x, y = self._at(point)
        reach = 0.8 * self._radius_m * self._scale
        for out in (0.0, 1.0):
            x0, y0 = x + out * ox - oy * reach, y + out * oy + ox * reach
            x1, y1 = x + out * ox + oy * reach, y + out * oy - ox * reach
            self._canvas.line(x0, y0, x1, y1, TOUCH)

    def lights(self, lit: set[bool]) -> None:
        """Draw a fan of rays before the front, behind the rear, or both."""
        wheels = self._pose.wheels
        for forward in lit:
            tip, before = (wheels[0], wheels[1]) if forward else (wheels[-1], wheels[-2])
            heading = atan2(tip[1] - before[1], tip[0] - before[0])
            for turn in (-0.35, 0.0, 0.35):
                angle = heading + turn
                near, far = 1.5 * self._radius_m, 3.4 * self._radius_m
                ends = [(tip[0] + r * cos(angle), tip[1] + r * sin(angle)) for r in (near, far)]
                self._canvas.line(*self._at(ends[0]), *self._at(ends[1]), LIGHT)

    def notes(self, origin: str) -> None:
        """Draw a bar that gives the scale, and write where the picture comes from."""
        canvas, length = self._canvas, round(_BAR_M * self._scale / ACROSS)
        bar = "├" + "─" * max(length - 2, 0) + "┤"
        scale = f"{bar} {_BAR_M * 1000:.0f} mm"
        canvas.write(0, canvas.height - DOWN, scale, NOTE)
        if origin:
            place = canvas.width - ACROSS * len(origin)
            beside = place > ACROSS * (len(scale) + 1)
            canvas.write(place, canvas.height - (1 if beside else 2) * DOWN, origin, NOTE)
