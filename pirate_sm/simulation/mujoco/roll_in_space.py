"""The roll joint of a chain that moves in space: a motor with a position controller of its own."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2

import mujoco
import numpy as np

from pirate_sm.core.geometry import Route
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.mujoco.names import LINK, ROLL, ROLL_REAR
from pirate_sm.simulation.physics import QuantityLayout

_AHEAD_RAD = 0.05
"""How far the controller's angle may run ahead of a joint that does not turn."""


class RollInSpace:
    """Turns the roll joint at its motor's speed, and reads how the two parts lie.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        route: The straight pipe that it is in.
        quantities: Where the quantities are written.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: ChainBody,
        route: Route,
        quantities: Floats,
    ) -> None:
        self._data, self._chain, self._quantities = data, chain, quantities
        layout = QuantityLayout(chain.nodes)
        self._roll, self._current = layout.at("roll"), layout.at("roll_current")
        frame = route.pieces[0].frame
        self._side, self._normal = np.array(frame.side), np.array(frame.normal)
        self._ahead = model.body(f"{LINK}0").id
        self._rear = model.body(f"{LINK}{len(chain.links) - 1}").id
        self._joint = self._motor = -1
        if chain.roll_link >= 0:
            self._joint = int(model.joint(ROLL).qposadr[0])
            self._motor = model.actuator(ROLL).id
            self._ahead = model.body(f"{LINK}{chain.roll_link}").id
            self._rear = model.body(ROLL_REAR).id
        self._target_rad = 0.0

    def turn_to(self, angle_rad: float) -> None:
        """Give the roll joint a new target."""
        self._target_rad = angle_rad

    def rolls(self) -> Sequence[float]:
        """Return the angle of the joint, then the roll of the part ahead and behind."""
        angle = float(self._data.qpos[self._joint]) if self._joint >= 0 else 0.0
        return (angle, self._roll_of(self._ahead), self._roll_of(self._rear))

    def prepare(self, cycle_s: float) -> None:
        """Let the controller's angle go towards the target for a cycle."""
        if self._joint < 0:
            return
        data, reach = self._data, self._chain.roll_rate_rad_s * cycle_s
        angle, now = float(data.qpos[self._joint]), float(data.ctrl[self._motor])
        aim = now + min(max(self._target_rad - now, -reach), reach)
        data.ctrl[self._motor] = min(max(aim, angle - _AHEAD_RAD), angle + _AHEAD_RAD)
        self._quantities[self._roll] = angle
        force = abs(float(data.actuator_force[self._motor]))
        self._quantities[self._current] = force / self._chain.roll_stall_nm

    def _roll_of(self, body: int) -> float:
        """Return how far the plane of a body is rolled about the pipe's axis, rad."""
        axle = self._data.xmat[body, 2::3]
        return atan2(float(axle @ self._side), float(axle @ self._normal))
