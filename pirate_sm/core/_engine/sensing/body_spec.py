"""The robot's chain of wheels and links, with the indexes of its signals, and the pipe around it.

A clamped part stands as a V between the walls, so its wheels show the axis of its straight: in
space, through a roll joint. Two parts in two straights show where these meet, and at which angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import acos, inf, isnan, nan
from typing import NamedTuple

from pirate_sm.core._engine.sensing import surveyor
from pirate_sm.core._geometry.chain import Chain
from pirate_sm.core._geometry.plane import turned
from pirate_sm.core._geometry.space import DRAWING, Frame, Place, Vector, between, combined, dot

WHOLE = -1
"""In place of a part's index: the whole chain."""


class Vee(NamedTuple):
    """A part that clamps as a V.

    Attributes:
        wheels: Its wheels, front to rear.
        angle: Number index of the angle at its apex.
        diameter: Number index of the inner diameter derived from this angle; -1 without one.
        end_stop_rad: Largest angle of the apex in either direction.
    """

    wheels: tuple[int, ...]
    angle: int
    diameter: int
    end_stop_rad: float


class BodyRows(NamedTuple):
    """The body as plain numbers, see :mod:`surveyor`.

    Attributes:
        chain: A row per wheel.
        parts: A row per part.
        imu: The accelerometer.
    """

    chain: tuple[tuple[float, ...], ...]
    parts: tuple[tuple[float, ...], ...]
    imu: tuple[int, ...]


class Imu(NamedTuple):
    """The accelerometer, on the half of its link ahead of a roll joint.

    Attributes:
        link: Index of its link.
        axes: Number indexes of the acceleration along the link ahead, towards side B and up.
        roll: Number index of its half's roll angle against the rear half; -1 without one.
    """

    link: int
    axes: tuple[int, int, int]
    roll: int


@dataclass(frozen=True)
class BodySpec(Chain):
    """The robot's chain with the indexes of its signals.

    Attributes:
        joints: Per wheel the number index of its joint's angle; -1 without a joint.
        parts: The clamping parts, in the order of the robot's parts.
        wheel_radius_m: Radius of the wheels.
        roll_link: Index of the link with a roll joint; -1 without one.
        imu: The accelerometer; None without one.
        roll: Number index of the roll joint's angle; -1 without one.
        weight_n: Weight of the whole robot.
    """

    joints: tuple[int, ...]
    parts: tuple[Vee, ...]
    wheel_radius_m: float
    roll_link: int = -1
    imu: Imu | None = None
    roll: int = -1
    weight_n: float = 0.0

    def wheels_of(self, part: int) -> tuple[int, ...]:
        """Return the wheels of a part, or of the ``WHOLE`` chain, front to rear."""
        return tuple(range(len(self.joints))) if part == WHOLE else self.parts[part].wheels

    def angles(self, numbers: Sequence[float]) -> tuple[float, ...]:
        """Return the angle at each wheel, rad: 0 without a joint, NaN where it is unknown."""
        return tuple(numbers[joint] if joint >= 0 else 0.0 for joint in self.joints)

    def heading_in_pipe(self, numbers: Sequence[float], part: int, link: int) -> float:
        """Return a link's heading relative to the pipe axis at a clamped part, rad.

        Args:
            numbers: The engine's signals; NaN is unknown.
            part: Index of the part.
            link: Index of the link.

        Returns:
            The heading, positive towards side A; NaN if an angle in between is unknown.
        """
        return surveyor.heading_in_pipe(part, link, numbers, self.rows.chain, self.rows.parts)

    @cached_property
    def rows(self) -> BodyRows:
        """Return it as plain numbers."""
        parts = [
            (vee.angle, vee.diameter, vee.end_stop_rad, vee.wheels[0], vee.wheels[-1])
            for vee in self.parts
        ]
        imu = self.imu
        return BodyRows(
            tuple(zip(self.joints, self.sides, (*self.lengths_m, 0.0), strict=True)),
            tuple((*part, self.wheel_radius_m) for part in parts),
            (-1, 0, 0, 0, -1) if imu is None else (imu.link, *imu.axes, imu.roll),
        )


def known(points: Sequence[Place], wheels: Sequence[int]) -> bool:
    """Return whether the positions of all these wheels are known."""
    return not any(isnan(points[wheel][0]) for wheel in wheels)


# --- the axis of the pipe at clamped parts ----------------------------------------------------


class Meeting(NamedTuple):
    """Where the axes at two parts come nearest to each other.

    Attributes:
        angle_rad: The angle between them, 0 to pi.
        behind_m: Distance along the axis of the part behind, from its middle to that place.
        ahead_m: Distance along the axis of the part ahead, from that place to its middle.
        apart_m: How far the axes pass each other there.
    """

    angle_rad: float
    behind_m: float
    ahead_m: float
    apart_m: float


def axis_at(body: BodySpec, numbers: Sequence[float], part: int) -> Frame | None:
    """Return the axis of the pipe at a clamped part; see :func:`axis_of`."""
    vee = body.parts[part]
    diameter_m = numbers[vee.diameter] if vee.diameter >= 0 else nan
    return axis_of(body, numbers, vee.wheels, diameter_m)


def axis_of(
    body: BodySpec, numbers: Sequence[float], wheels: Sequence[int], diameter_m: float
) -> Frame | None:
    """Return the axis of a pipe whose walls these wheels touch; None if it is unknown.

    Args:
        body: The robot's chain.
        numbers: Every signal in SI; NaN is unknown.
        wheels: Wheels of one part, front to rear; each touches its side.
        diameter_m: Inner diameter of the pipe.

    Returns:
        The frame of the axis at the middle of the wheels, which lie in the plane of ``ahead`` and
        ``side``. Its coordinates are those of the rear half of the link with the roll joint, or of
        the first link: its front wheel is the origin, x is ahead along it.
    """
    places = body.places(body.angles(numbers), max(body.roll_link, 0))
    aside_m = diameter_m / 2 - body.wheel_radius_m
    turn = body.lean(places, wheels, aside_m)
    laid = [turned(places[wheel], turn) for wheel in wheels]
    along = sum(x for x, _ in laid) / len(laid)
    asides = [y - body.sides[wheel] * aside_m for wheel, (_, y) in zip(wheels, laid, strict=True)]
    x, y = turned((along, sum(asides) / len(laid)), -turn)
    plane = _plane_of(body, numbers, wheels[0])
    if isnan(x + y) or isnan(plane.side[1]):
        return None
    return plane.turned(-turn)._replace(origin=plane.point(x, y))


def wheel_at(body: BodySpec, numbers: Sequence[float], wheel: int) -> Vector:
    """Return the place of a wheel in the coordinates of :func:`axis_of`, m; NaN is unknown."""
    places = body.places(body.angles(numbers), max(body.roll_link, 0))
    return _plane_of(body, numbers, wheel).point(*places[wheel])


def plane_of(body: BodySpec, numbers: Sequence[float], part: int) -> Frame:
    """Return the frame in whose plane a part lies, in the coordinates of :func:`axis_of`."""
    return _plane_of(body, numbers, body.parts[part].wheels[0])


def _plane_of(body: BodySpec, numbers: Sequence[float], wheel: int) -> Frame:
    if body.roll < 0 or wheel > body.roll_link:
        return DRAWING
    return DRAWING.rolled(numbers[body.roll])


def meeting(behind: Frame, ahead: Frame) -> Meeting:
    """Return where two axes come nearest to each other; of parallel ones the place is infinite."""
    cosine = max(-1.0, min(1.0, dot(behind.ahead, ahead.ahead)))
    sine2 = 1.0 - cosine * cosine
    offset = between(behind.origin, ahead.origin)
    along, back = dot(offset, behind.ahead), dot(offset, ahead.ahead)
    if sine2 <= 0.0:
        return Meeting(acos(cosine), inf, inf, 0.0)
    first_m = (along - cosine * back) / sine2
    second_m = (back - cosine * along) / sine2
    gap = combined((1.0, offset), (-first_m, behind.ahead), (-second_m, ahead.ahead))
    return Meeting(acos(cosine), first_m, second_m, dot(gap, gap) ** 0.5)
