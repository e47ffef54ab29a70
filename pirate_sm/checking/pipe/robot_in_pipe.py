"""Compute a robot's length, contact forces and weight force in a pipe."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import inf, sqrt

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.geometry.clamping import press_n, span_m
from pirate_sm.geometry.route import Piece, Route
from pirate_sm.geometry.space import GRAVITY_M_S2, dot
from pirate_sm.model.pipe import Pipe
from pirate_sm.model.profile import Profile


@dataclass(frozen=True)
class Fit:
    """A robot in a pipe.

    Attributes:
        profile: The robot.
        robot: The engine's specification of the robot, in the polarity of the mission.
        pipe: The pipe.
    """

    profile: Profile
    robot: RobotSpec
    pipe: Pipe

    @cached_property
    def route(self) -> Route:
        """Return the route through the pipe."""
        return self.pipe.route()

    @property
    def height_m(self) -> float:
        """Return the height h of a clamped V, m (eq. 3-2)."""
        return self.pipe.diameter - 2 * self.profile.body.wheel_radius

    @property
    def stretched_m(self) -> float:
        """Return the length of the straight robot from the first wheel to the last, m."""
        return sum(link.length for link in self.profile.body.links)

    @property
    def clamped_m(self) -> float:
        """Return the length of the robot with adjacent wheels on opposite walls, m."""
        lengths = [link.length for link in self.profile.body.links]
        return sum(span_m(length, self.height_m) for length in lengths)

    @property
    def weight_n(self) -> float:
        """Return the weight of the whole robot, N."""
        body = self.profile.body
        masses = [*(wheel.mass for wheel in body.wheels), *(link.mass for link in body.links)]
        return sum(masses) * GRAVITY_M_S2

    @property
    def friction(self) -> float:
        """Return the static friction coefficient."""
        friction = self.pipe.friction or self.profile.simulation.friction
        return friction.static

    def pull_n(self, piece: Piece) -> tuple[float, float]:
        """Return the weight's components along a piece of pipe and against its walls, N."""
        slope = dot(self.route.up, piece.frame.ahead)
        return abs(slope) * self.weight_n, sqrt(max(1 - slope**2, 0.0)) * self.weight_n

    def torque_nm(self, part: int, configuration: int) -> float:
        """Return the stall torque of a held part's apex, Nm; infinite if the states set none."""
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
        """Return the sum of the normal forces of a held part, N."""
        leg_m = min(self.profile.body.legs_m(self.robot.parts[part]))
        return press_n(self.torque_nm(part, configuration), leg_m, self.height_m)
