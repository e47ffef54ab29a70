"""What an inertial unit on the link with the roll joint feels."""

from __future__ import annotations

import mujoco
import numpy as np

from pirate_sm.core.geometry import Vector
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.mujoco.names import LINK, WHEEL
from pirate_sm.simulation.physics import QuantityLayout

# Along the first leg and against its normal, uT: the kinematic simulator's, in the same axes.
_FIELD_UT = (20.0, 0.0, -44.0)


class InertialUnit:
    """Writes specific force and magnetic field along forward, side B and up.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        quantities: Where the quantities are written.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, chain: ChainBody, quantities: Floats
    ) -> None:
        first = QuantityLayout(chain.nodes).at("acc_x")
        self._out = quantities[first : first + 6]
        link = min(max(chain.roll_link, 0), len(chain.links) - 1)
        self.wheel = link
        self._data = data
        self._link = model.body(f"{LINK}{link}").id
        self._place = model.body(f"{WHEEL}{link}").id
        self._before: Floats | None = None
        self._chain = chain
        self._velocity = np.zeros(3)

    def read(self, gravity: Vector, roll_rad: float, cycle_s: float) -> None:
        """Write what it feels after a cycle; the specific force is averaged.

        Args:
            gravity: Where the unit is, in its own plane and square to it, m/s².
            roll_rad: How far it is rolled beside what its link's frame shows.
            cycle_s: Length of the cycle.
        """
        place = self._data.xpos[self._place].copy()
        share = 1.0 if self._before is None else self._chain.felt_share(cycle_s)
        before = place if self._before is None else self._before
        velocity = (place - before) / cycle_s
        acceleration = (velocity - self._velocity) / cycle_s
        self._before, self._velocity = place, velocity
        axes = self._data.xmat[self._link].reshape(3, 3).T * [[1.0], [-1.0], [-1.0]]
        self._out[:3] += share * (axes @ (acceleration - gravity) - self._out[:3])
        field = axes @ _FIELD_UT
        cos, sin = np.cos(roll_rad), np.sin(roll_rad)
        self._out[3] = field[0]
        self._out[4] = field[1] * cos - field[2] * sin
        self._out[5] = field[1] * sin + field[2] * cos
