"""How a robot stands in a pipe: its length, how hard it holds, and what its weight pulls.

Holding follows the thesis: the clamp force of a part is tau / sqrt(l^2 - h^2) * (1, 2, 1) on the
three wheels of its V (eq. 3-3) with h = diameter - 2r (eq. 3-2), and friction must bear
m g sin(alpha) (eq. 3-14). Equations 3-24 and 3-25, which join the two, are not used: as printed
they change their sign where tan(alpha) is half the friction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, inf, sin, sqrt, tan
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.model.pipe import Mitre, Pipe
from pirate_sm.model.profile import Profile

GRAVITY_M_S2 = 9.81
WHEELS_SHARE = 4.0
"""Sum of the shares (1, 2, 1) that a part's wheels have of its clamp force (eq. 3-3)."""


class Leg(NamedTuple):
    """A straight part of the pipe between bends.

    Attributes:
        segment: Index of its first straight.
        begins_m: Where it begins along the axis; a bend is there unless it is the first leg.
        length_m: Its length along the axis, from crossing to crossing.
        taken_m: What the bends at its two ends take of the inner wall.
        heading_rad: Its direction in the plane, from that of the first leg towards side A.
    """

    segment: int
    begins_m: float
    length_m: float
    taken_m: tuple[float, float]
    heading_rad: float

    @property
    def ends_m(self) -> float:
        """Where it ends along the axis."""
        return self.begins_m + self.length_m

    @property
    def clear_m(self) -> tuple[float, float]:
        """Where, along the axis, both walls are there."""
        return self.begins_m + self.taken_m[0], self.ends_m - self.taken_m[1]


def legs_of(pipe: Pipe) -> tuple[Leg, ...]:
    """The legs of a pipe in order."""
    legs: list[Leg] = []
    first, begins, length, before, heading = 0, 0.0, 0.0, 0.0, 0.0
    for number, segment in enumerate((*pipe.segments, None)):
        if segment is not None and not isinstance(segment, Mitre):
            length += segment.straight
            continue
        angle = segment.mitre if segment is not None else 0.0
        after = pipe.diameter / 2 * tan(abs(angle) / 2)
        legs.append(Leg(first, begins, length, (before, after), heading))
        first, begins, length, before = number + 1, begins + length, 0.0, after
        heading += angle
    return tuple(legs)


@dataclass(frozen=True)
class Fit:
    """A robot in a pipe.

    Attributes:
        robot: In the polarity of the mission.
    """

    profile: Profile
    robot: RobotSpec
    pipe: Pipe

    @property
    def height_m(self) -> float:
        """h, the height of a clamped V (eq. 3-2)."""
        return self.pipe.diameter - 2 * self.profile.body.wheel_radius

    @property
    def stretched_m(self) -> float:
        """From the first wheel to the last of a straight robot."""
        return sum(link.length for link in self.profile.body.links)

    @property
    def clamped_m(self) -> float:
        """From the first wheel to the last where neighbours touch opposite walls."""
        lengths = [link.length for link in self.profile.body.links]
        return sum(sqrt(max(length**2 - self.height_m**2, 0.0)) for length in lengths)

    @property
    def weight_n(self) -> float:
        """Of the whole robot."""
        body = self.profile.body
        masses = [*(wheel.mass for wheel in body.wheels), *(link.mass for link in body.links)]
        return sum(masses) * GRAVITY_M_S2

    @property
    def friction(self) -> float:
        """The static friction coefficient in force."""
        friction = self.pipe.friction or self.profile.simulation.friction
        return friction.static

    def pull_n(self, leg: Leg) -> tuple[float, float]:
        """What the weight pulls along a leg, and what of it rests on the walls."""
        slope = sin(self.pipe.tilt) * cos(self.pipe.uphill - leg.heading_rad)
        return abs(slope) * self.weight_n, sqrt(max(1 - slope**2, 0.0)) * self.weight_n

    def torque_nm(self, part: int, configuration: int) -> float:
        """The torque of a held part's apex at stall; infinite where the states do not say."""
        joint = self.profile.body.parts[self.robot.parts[part]].apex
        states = self.robot.table.configurations[configuration]
        least = inf
        for region, state in enumerate(states):
            for stage in self.robot.actuation[region][state]:
                for write in stage:
                    slot = self.profile.slots[write.slot]
                    stall = self.profile.motors[slot.motor].stall_torque
                    if slot.joint == joint and write.how == "set" and stall is not None:
                        least = min(least, abs(write.value) * stall)
        return least

    def press_n(self, part: int, configuration: int) -> float:
        """The sum of the normal forces of a held part (eq. 3-3)."""
        leg = self._leg_m(part)
        lever = sqrt(max(leg**2 - self.height_m**2, 0.0))
        torque = self.torque_nm(part, configuration)
        return WHEELS_SHARE * torque / lever if lever > 0 else inf

    def _leg_m(self, part: int) -> float:
        """Length of a leg of a part's V; a link with a roll joint in it is none."""
        body = self.profile.body
        apex = next(
            each for each in body.joints if each.name == body.parts[self.robot.parts[part]].apex
        )
        node = next(i for i, wheel in enumerate(body.wheels) if wheel.name == apex.wheel)
        beside = body.links[node - 1 : node + 1]
        legs: Sequence[float] = [link.length for link in beside if link.roll is None]
        return min(legs or [link.length for link in beside])
