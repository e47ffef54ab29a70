"""Dead reckoning: where each wheel is along the pipe, from the joints and the odometer alone.

A part whose clamp is confirmed is the anchor: the mean place of its wheels moves by what the
odometer counts and by nothing else. It lies in its leg with each wheel at the wall that it
touches when clamped, and the measured angles of the bend joints give the rest of the chain, also
round a mitre. Without a confirmed clamp all wheels are the anchor, on the centre line.

Neglected: slip; that a part may shift while it clamps, relaxes or is pushed; roll, so that the
robot's plane is taken for the pipe's; the odometer's own lag of one round of the boards; an
anchor that stands in two legs at once is taken to lie in that of its middle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, atan2, cos, hypot, isnan, sin
from typing import NamedTuple

from pirate_sm.detectors.route import Leg, Place, Route
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile


@dataclass(frozen=True)
class Chain:
    """The robot's body in its plane.

    Attributes:
        lengths_m: Length of each link, front to rear; the first lies between wheels 0 and 1.
        joints: Per wheel the index of the number with its joint's angle; -1 without a joint.
        aside_m: Per wheel how far from the centre line it is when clamped, towards side A.
        parts: Wheels of each part, in the order of the robot's parts.
    """

    lengths_m: tuple[float, ...]
    joints: tuple[int, ...]
    aside_m: tuple[float, ...]
    parts: tuple[tuple[int, ...], ...]


def chain_of(profile: Profile, robot: RobotSpec, pipe: Pipe) -> Chain:
    """The chain of a robot as it stands in a pipe of this inner diameter."""
    body, names = profile.body, robot.vocabulary.numbers
    joints = {joint.wheel: names.index(joint.name) for joint in body.joints}
    aside = pipe.diameter / 2 - body.wheel_radius
    if robot.polarity == "mirrored":
        aside = -aside
    return Chain(
        tuple(link.length for link in body.links),
        tuple(joints.get(wheel.name, -1) for wheel in body.wheels),
        tuple(wheel.direction * aside for wheel in body.wheels),
        tuple(
            tuple(index for index, wheel in enumerate(body.wheels) if wheel.part == part)
            for part in robot.parts
        ),
    )


class Reckoned(NamedTuple):
    """What is taken to be so.

    Attributes:
        places_m: Place of each wheel along the pipe.
        points: Where that is in the plane of the pipe.
        angles_rad: Angle of each wheel's joint when it was last known; 0 before and without one.
        odometer_m: What the odometer showed.
        anchor: Index of the part that is the anchor, -1 for the whole chain.
        leg: Which leg the anchor is taken to lie in.
    """

    places_m: tuple[float, ...]
    points: tuple[Place, ...]
    angles_rad: tuple[float, ...]
    odometer_m: float
    anchor: int
    leg: Leg


class Reckoner:
    """Takes a reckoning from one look to the next; keeps nothing itself.

    Args:
        chain: The body.
        route: The pipe.
        odometer: Index of the number that the odometer is.
    """

    def __init__(self, chain: Chain, route: Route, odometer: int) -> None:
        self._chain = chain
        self._route = route
        self._odometer = odometer
        self._everything = tuple(range(len(chain.joints)))

    def begin(
        self, first_wheel_m: float, numbers: Sequence[float], held: frozenset[int] = frozenset()
    ) -> Reckoned:
        """The first wheel began at this place, when the odometer stood at zero.

        Args:
            first_wheel_m: That place along the pipe; the whole robot is in the same leg.
            numbers: The engine's signals in SI.
            held: Parts whose clamp is confirmed.
        """
        angles = self._angles(numbers, (0.0,) * len(self._chain.joints))
        counted = self._counted(numbers, 0.0)
        place = first_wheel_m + counted
        return self._put(angles, counted, min(held, default=-1), (0,), place)

    def look(self, before: Reckoned, numbers: Sequence[float], held: frozenset[int]) -> Reckoned:
        """Where the wheels are now; arguments as of :meth:`begin`."""
        angles = self._angles(numbers, before.angles_rad)
        counted = self._counted(numbers, before.odometer_m)
        anchor = before.anchor if before.anchor in held else min(held, default=-1)
        wheels = self._wheels(anchor)
        leg = before.leg
        if anchor != before.anchor:
            leg = self._route.leg_at(_mean([before.places_m[wheel] for wheel in wheels]))
        # Not the mean of the places: they leap where a wheel cuts the corner of a mitre.
        middle = _mean([leg.beyond(before.points[wheel]) for wheel in wheels])
        middle += leg.arc_m + counted - before.odometer_m
        return self._put(angles, counted, anchor, wheels, middle)

    def _wheels(self, anchor: int) -> tuple[int, ...]:
        return self._chain.parts[anchor] if anchor >= 0 else self._everything

    def _angles(self, numbers: Sequence[float], before: tuple[float, ...]) -> tuple[float, ...]:
        """Angles at the wheels; one that is unknown is what it was."""
        return tuple(
            old if joint < 0 or isnan(numbers[joint]) else numbers[joint]
            for joint, old in zip(self._chain.joints, before, strict=True)
        )

    def _counted(self, numbers: Sequence[float], before: float) -> float:
        counted = numbers[self._odometer] if self._odometer >= 0 else before
        return before if isnan(counted) else counted

    def _put(
        self,
        angles: tuple[float, ...],
        counted: float,
        anchor: int,
        at: tuple[int, ...],
        middle_m: float,
    ) -> Reckoned:
        """The chain lies in the pipe with the middle of the wheels ``at`` at a place."""
        shape, chain, wheels = self._shape(angles), self._chain, self._wheels(anchor)
        aside = chain.aside_m if anchor >= 0 else (0.0,) * len(chain.aside_m)
        (x0, y0), (x1, y1) = shape[wheels[-1]], shape[wheels[0]]
        rise = (aside[wheels[0]] - aside[wheels[-1]]) / (hypot(x1 - x0, y1 - y0) or 1.0)
        turn = asin(max(-1.0, min(1.0, rise))) - atan2(y1 - y0, x1 - x0)
        turned = [(x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)) for x, y in shape]
        leg = self._route.leg_at(middle_m)
        forward = middle_m - _mean([turned[wheel][0] for wheel in at])
        across = _mean([aside[wheel] - turned[wheel][1] for wheel in wheels])
        points = tuple(leg.point(x + forward, y + across) for x, y in turned)
        places = tuple(map(self._route.place_of, points))
        return Reckoned(places, points, angles, counted, anchor, leg)

    def _shape(self, angles: tuple[float, ...]) -> list[Place]:
        """The chain from the first wheel at the origin, its first link along x.

        A joint's angle is the heading of the link ahead less that of the link behind, counted
        away from side A.
        """
        x = y = heading = 0.0
        shape = [(x, y)]
        for wheel, length in enumerate(self._chain.lengths_m):
            if wheel > 0:
                heading += angles[wheel]
            x, y = x - length * cos(heading), y - length * sin(heading)
            shape.append((x, y))
        return shape


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
