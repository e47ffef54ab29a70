"""A chain of wheels and links: its kinematics in a plane and in space, its statics, its clamps.

*Kinematics.* The angle of a joint is the heading of the link behind it minus that of the link
ahead, both positive towards side A: a negative angle turns the body ahead towards side A (thesis
section 3-2). An unknown angle is NaN, and so is every position and heading that depends on it.

*Statics.* Links are rigid, half of a link's mass goes to each of its ends, and the robot moves
slowly, so that forces balance at every wheel. A joint's torque is a couple on each of its two
links; so is the reaction of a wheel's motor on the link that it sits on. A couple C on a link of
length l is borne by a pair of forces C / l across its ends. What is unknown are the normal forces,
and a force along each link; an excess of force along the pipe is borne by braked wheels, or by an
obstacle at the leading end. The frame lies in the plane of the chain: x along the pipe, ahead; y
towards side A. Headings count towards side A, and so do couples.

*Clamps.* The clamp force of a part is tau / sqrt(l^2 - h^2) * (1, 2, 1) on the three wheels of its
V (thesis eq. 3-3) with h = diameter - 2 r (eq. 3-2). Friction must bear m g sin(alpha) (eq. 3-14).
Equations 3-24 and 3-25, which combine the two, are not used: as printed they change sign where
tan(alpha) is half the friction coefficient.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, cos, inf, isnan, nan, sin, sqrt
from typing import NamedTuple

from pirate_sm.core._geometry.route import turned
from pirate_sm.core._geometry.space import Frame, Place, Vector

# --- kinematics in a plane --------------------------------------------------------------------


class Pose(NamedTuple):
    """Position and heading of a link in the plane, m and rad.

    The origin of a link's frame is its front wheel; x points ahead along the link.
    """

    x_m: float
    y_m: float
    heading_rad: float


ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Chain:
    """Wheels joined by rigid links, front to rear.

    Attributes:
        lengths_m: Length of each link; the first one lies between wheels 0 and 1.
        sides: Per wheel the side that it touches while its part is clamped: 1 is A, -1 is B.
    """

    lengths_m: tuple[float, ...]
    sides: tuple[int, ...]

    def headings(
        self, angles: Sequence[float], first: int = 0, heading_rad: float = 0.0
    ) -> list[float]:
        """Return the heading of each link, rad.

        Args:
            angles: Joint angle at each wheel, rad; those of the two end wheels are ignored.
            first: Index of the reference wheel; the last wheel refers to the link ahead of it.
            heading_rad: Heading of the link behind the reference wheel.
        """
        first = min(first, len(self.lengths_m) - 1)
        headings = [heading_rad] * len(self.lengths_m)
        for link in range(first + 1, len(headings)):
            headings[link] = headings[link - 1] + angles[link]
        for link in range(first - 1, -1, -1):
            headings[link] = headings[link + 1] - angles[link + 1]
        return headings

    def places(self, angles: Sequence[float], first: int = 0, pose: Pose = ORIGIN) -> list[Place]:
        """Return the position of each wheel, m, given the pose of the link behind wheel ``first``.

        Args:
            angles: See :meth:`headings`.
            first: See :meth:`headings`.
            pose: Pose of the link behind the reference wheel.
        """
        headings, lengths_m = self.headings(angles, first, pose.heading_rad), self.lengths_m
        first = min(first, len(lengths_m) - 1)
        x, y = start = pose.x_m, pose.y_m
        places: list[Place] = [start] * (len(lengths_m) + 1)
        for link in range(first, len(lengths_m)):
            x -= lengths_m[link] * cos(headings[link])
            y -= lengths_m[link] * sin(headings[link])
            places[link + 1] = x, y
        x, y = start
        for link in range(first - 1, -1, -1):
            x += lengths_m[link] * cos(headings[link])
            y += lengths_m[link] * sin(headings[link])
            places[link] = x, y
        return places

    def lean(self, places: Sequence[Place], wheels: Sequence[int], aside_m: float) -> float:
        """Return the rotation of the chain that aligns a part with the pipe, rad.

        Args:
            places: Positions of all wheels, m.
            wheels: Wheels of the part; each touches its side of the pipe.
            aside_m: Distance from the pipe's axis of a wheel that touches a side.
        """
        front, rear = wheels[0], wheels[-1]
        along, across = places[front][0] - places[rear][0], places[front][1] - places[rear][1]
        # Not `hypot`, which rounds differently from one language to the next.
        length_m = sqrt(along * along + across * across) or 1.0
        rise = (self.sides[front] - self.sides[rear]) * aside_m / length_m
        if isnan(rise):
            return nan
        return asin(max(-1.0, min(1.0, rise))) - atan2(across, along)


# --- in space: two planar parts with a roll joint between them --------------------------------


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


# --- statics ----------------------------------------------------------------------------------


LEAST_COSINE = 0.2
"""A link that stands across the pipe more steeply than this (78 deg) bears no force along it."""


class ChainLoads(NamedTuple):
    """What acts on a chain of wheels and links.

    Attributes:
        headings_rad: Of each link against the axis of the pipe.
        couples_nm: On each link, from joints and from the reactions of wheel motors.
        drives_n: Force along the pipe by which each wheel's motor pushes the robot ahead.
        braked: Whether each wheel is braked; it bears what force it must.
        gravity_m_s2: Its components along x and y.
    """

    headings_rad: Sequence[float]
    couples_nm: Sequence[float]
    drives_n: Sequence[float]
    braked: Sequence[bool]
    gravity_m_s2: tuple[float, float]


def couples_nm(
    joint_torques_nm: Sequence[float], wheel_torques_nm: Sequence[float], mounts: Sequence[int]
) -> list[float]:
    """Return the couple on each link.

    Args:
        joint_torques_nm: At each wheel, 0 where there is no joint. A positive one increases the
            joint's angle: it turns the link behind towards side A and the link ahead to side B.
        wheel_torques_nm: By which each motor turns its wheel.
        mounts: Index of the link that each wheel's motor sits on.
    """
    links = len(joint_torques_nm) - 1
    couples = [0.0] * links
    for node in range(1, links):
        couples[node] += joint_torques_nm[node]
        couples[node - 1] -= joint_torques_nm[node]
    for torque, link in zip(wheel_torques_nm, mounts, strict=True):
        couples[link] -= torque
    return couples


def normal_forces_n(
    lengths_m: Sequence[float], masses_kg: Sequence[float], sides: Sequence[int], loads: ChainLoads
) -> list[float]:
    """Return the normal force of each wheel, N; NaN for all where something is unknown.

    Args:
        lengths_m: Of the links, front to rear.
        masses_kg: At each wheel, with half of its links.
        sides: Per wheel the side that it touches: 1 is A, -1 is B.
        loads: What acts on the chain.
    """
    along = _along_n(masses_kg, loads)
    if isnan(sum(along)):
        return [nan] * len(masses_kg)
    ends = _across_links(lengths_m, loads)
    forces, pull = [], (0.0, 0.0)  # of the link ahead, on its rear end
    for node, mass_kg in enumerate(masses_kg):
        x = along[node] + ends[node][0] + pull[0] + mass_kg * loads.gravity_m_s2[0]
        y = ends[node][1] + pull[1] + mass_kg * loads.gravity_m_s2[1]
        if node < len(lengths_m):
            heading = loads.headings_rad[node]
            if not abs(cos(heading)) >= LEAST_COSINE:
                return [nan] * len(masses_kg)
            tension = x / cos(heading)
            pull = tension * cos(heading), tension * sin(heading)
            y -= pull[1]
        forces.append(y * sides[node])
    return [nan] * len(forces) if isnan(sum(forces)) else forces


def _along_n(masses_kg: Sequence[float], loads: ChainLoads) -> list[float]:
    """Return the force along the pipe on each wheel from its wall, or from an obstacle."""
    weight = sum(masses_kg) * loads.gravity_m_s2[0]
    excess = sum(loads.drives_n) + weight
    along = list(loads.drives_n)
    braked = [node for node, each in enumerate(loads.braked) if each]
    if braked:
        for node in braked:
            along[node] -= excess / len(braked)
    else:
        along[0 if excess > 0 else -1] -= excess
    return along


def _across_links(lengths_m: Sequence[float], loads: ChainLoads) -> list[tuple[float, float]]:
    """Return the force on each wheel by which its links bear their couples."""
    found = [(0.0, 0.0)] * (len(lengths_m) + 1)
    for link, (length_m, heading) in enumerate(zip(lengths_m, loads.headings_rad, strict=True)):
        size = loads.couples_nm[link] / length_m
        x, y = -sin(heading) * size, cos(heading) * size
        (ahead_x, ahead_y), (behind_x, behind_y) = found[link], found[link + 1]
        found[link] = (ahead_x + x, ahead_y + y)
        found[link + 1] = (behind_x - x, behind_y - y)
    return found


# --- clamps -----------------------------------------------------------------------------------


WHEELS_SHARE = 4.0
"""Sum of the wheels' shares (1, 2, 1) in a part's clamp force (eq. 3-3)."""


HELD_SAFETY = 1.25
"""By this factor a part that holds alone presses harder than friction asks for [decided]."""


def height_m(leg_m: float, apex_rad: float) -> float:
    """Return the height h of a V with legs of one length whose apex has this angle (eq. 3-2)."""
    return abs(leg_m * sin(apex_rad / 2))


def span_m(leg_m: float, height_m: float) -> float:
    """Return the length along the pipe of a link from wall to wall, m; 0 if it is too short."""
    return sqrt(max(leg_m * leg_m - height_m * height_m, 0.0))


def press_n(torque_nm: float, leg_m: float, height_m: float) -> float:
    """Return the sum of the normal forces of a V whose apex has this torque (eq. 3-3)."""
    lever = span_m(leg_m, height_m)
    return WHEELS_SHARE * torque_nm / lever if lever > 0 else inf


def holding_nm(pull_n: float, friction: float, leg_m: float, height_m: float) -> float:
    """Return the torque at the apex of a V that alone bears a pull along the pipe (eq. 3-3, 3-14).

    Args:
        pull_n: The pull.
        friction: Static friction of its wheels.
        leg_m: Length of its legs.
        height_m: Height of the V.
    """
    pressed_n = HELD_SAFETY * pull_n / friction if friction > 0 else inf
    return pressed_n * span_m(leg_m, height_m) / WHEELS_SHARE
