"""The simplest physics there can be: joints obey at once, wheels roll without slip.

Nothing has a mass. A joint turns at its motor's speed without load until its V fills the pipe, and
bears the motor's torque there; the robot moves with the mean of its wheels. It proves that the
simulation asks nothing of a physics that its protocol does not say.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pirate_sm.core.geometry import Route, Vector
from pirate_sm.core.models import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.physics import ChainBody, QuantityLayout, StartPose


class ObedientPhysics:
    """A chain in a pipe that does what it is told; arguments as of any physics."""

    def __init__(
        self, chain: ChainBody, route: Route, friction: Friction, pose: StartPose, cycle_s: float
    ) -> None:
        n, layout = chain.nodes, QuantityLayout(chain.nodes)
        self.duties: Floats = np.zeros(2 * n)
        self.quantities: Floats = np.zeros(layout.size)
        self._chain, self._route, self._cycle_s = chain, route, cycle_s
        self._bend, self._torque, self._current, self._turned, self._wheel, self._press = (
            self.quantities[layout.block(name)]
            for name in ("bend", "bend_torque", "bend_current", "turned", "wheel", "press")
        )
        self._arc = self.quantities[layout.block("arc")]
        self._roll = layout.at("roll")
        self._roll_rad = pose.roll_rad
        self._rates = np.array([wheel.rate_rad_s for wheel in chain.wheels])
        self._signs = np.array([1.0 if i % 2 == 0 else -1.0 for i in range(n)])
        self._stiff = np.zeros(n)
        self._blocked: tuple[int, float, float] | None = None
        height = route.pieces[0].diameter_m - 2.0 * chain.wheel_radius_m
        self._span = 2.0 * math.asin(min(1.0, height / chain.links[0].length_m))
        self._bend[:] = pose.bends_rad
        # A robot starts in the first leg, whose axis is x.
        self._arc[:] = [place[0] for place in pose.places]
        self._offsets = [place[1] for place in pose.places]
        self.quantities[layout.at("acc_z")] = 9.81

    def turn_roll_to(self, angle_rad: float) -> None:
        self.quantities[self._roll] = angle_rad

    def advance(self) -> None:
        n = self._chain.nodes
        for i, joint in self._chain.joints.items():
            duty = float(self.duties[i])
            self._current[i] = abs(duty)
            if abs(duty) * joint.stall_nm <= self._stiff[i]:
                continue
            turned = self._bend[i] + joint.rate_rad_s * duty * self._cycle_s
            self._bend[i] = min(max(turned, -self._span), self._span)
            self._torque[i] = duty * joint.stall_nm if self._bend[i] != turned else 0.0
        self._press[:] = np.abs(self._torque).max() / self._chain.links[0].length_m
        speeds = self._signs * self._rates * self.duties[n:]
        way = float(speeds.mean()) * self._cycle_s * self._chain.wheel_radius_m
        if self._blocked is not None:
            wheel, arc_m, sign = self._blocked
            left = max(sign * (arc_m - float(self._arc[wheel])) - self._chain.wheel_radius_m, 0.0)
            way = sign * min(sign * way, left)
        self._arc += way
        self._turned[:] = self._signs * way / self._chain.wheel_radius_m
        self._wheel += self._turned

    def places(self) -> Sequence[Vector]:
        arcs = zip(self._arc.tolist(), self._offsets, strict=True)
        return [self._route.piece_at(arc).point(arc, offset) for arc, offset in arcs]

    def rolls(self) -> Sequence[float]:
        return float(self.quantities[self._roll]), self._roll_rad, self._roll_rad

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        self._blocked = wheel, arc_m, 1.0 if ahead else -1.0

    def unblock(self) -> None:
        self._blocked = None

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        self._rates[wheel] = 0.0

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        pass  # nothing slips

    def turn_gravity(self, up: Vector) -> None:
        pass  # nothing weighs anything

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        self._stiff[wheel] = friction_nm
