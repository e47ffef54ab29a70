"""The edges of the tyres of MuJoCo's wheels in space."""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot, sqrt

import mujoco
import numpy as np

from pirate_sm.core.geometry import Vector, dot
from pirate_sm.simulation.mujoco.model_text import WHEEL
from pirate_sm.simulation.physics import ChainBody

_ON_ITS_SIDE = 0.999
"""Sine of the lean beyond which a wheel counts as leaning so far."""


class TyreEdges:
    """Lets wheels roll on the edges of their tyres, as the kinematic simulator does.

    A sphere rolls on a circle whose radius is its own times the sine of the angle between axle and
    normal. A tyre touches with its edge at most, so the axle is turned, in the plane of both, until
    the wheel leans no farther than that.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, chain: ChainBody) -> None:
        self._data = data
        bodies = [model.body(f"{WHEEL}{i}").id for i in range(chain.nodes)]
        self._bodies = np.array(bodies, dtype=np.intp)
        self._links = model.body_parentid[self._bodies]
        self._axles = model.body_quat
        self._most_lean = min(chain.tyre_half_width_m / chain.wheel_radius_m, 1.0)

    def turn_axles(self, normals: Sequence[Vector]) -> None:
        """Turn the axles for the next cycle, by the normal of the wall where each wheel presses."""
        axes = self._data.xmat[self._links].tolist()
        self._axles[self._bodies] = [
            self._turned(normal, link) for normal, link in zip(normals, axes, strict=True)
        ]

    def _turned(self, normal: Vector, link: Sequence[float]) -> tuple[float, float, float, float]:
        """Return the quaternion by which a wheel is turned in its link, whose axes are given."""
        z = dot(normal, (link[2], link[5], link[8]))
        most = self._most_lean
        if abs(z) <= most:
            return 1.0, 0.0, 0.0, 0.0
        x, y = dot(normal, (link[0], link[3], link[6])), dot(normal, (link[1], link[4], link[7]))
        z, leans = (min(max(z, -each), each) for each in (_ON_ITS_SIDE, most))
        # The axle is a share of what of it lies along the wall, and leans along the normal.
        along = sqrt((1.0 - leans * leans) / (1.0 - z * z))
        aside = leans - z * along
        turned = (1.0 + z * leans + (1.0 - z * z) * along, -y * aside, x * aside)
        share = 1.0 / hypot(*turned)
        return share * turned[0], share * turned[1], share * turned[2], 0.0
