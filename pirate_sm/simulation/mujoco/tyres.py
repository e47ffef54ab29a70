"""The tyres of MuJoCo's wheels in space: they creep as they roll, and have edges."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, hypot, sqrt

import mujoco
import numpy as np

from pirate_sm.core.geometry import Vector, dot
from pirate_sm.simulation.mujoco.model_text import WHEEL
from pirate_sm.simulation.physics import SLIDING_SLIP, ChainBody

_RELAXES_M = 0.003
"""A tyre creeps fully after it has rolled some times as far: about half the length of its contact
(Pacejka, chapter 5), √(radius × depth) by Hertz under 30 N on 1e5 N/m [assumed]. Without it, what a
wheel slips as it starts depends on the length of a step."""

_ON_ITS_SIDE = 0.999
"""Sine of the lean beyond which a wheel counts as leaning so far."""


class Tyres:
    """Lets wheels creep and roll on the edges of their tyres, as the kinematic simulator does.

    *Creep.* MuJoCo's friction gives way: a contact slips by its force × `efc_R` / damping. A wheel
    that rolls is given the damping with which it slips by :data:`SLIDING_SLIP` of its speed where
    the force reaches the friction, and in proportion below; MuJoCo's own damping is the most.

    *Edges.* A sphere rolls on a circle whose radius is its own times the sine of the angle between
    axle and normal. A tyre touches with its edge at most, so the axle is turned, in the plane of
    both, until the wheel leans no farther than that.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        cycle_s: Length of a cycle.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, chain: ChainBody, cycle_s: float
    ) -> None:
        self._data, self._radius_m, self._cycle_s = data, chain.wheel_radius_m, cycle_s
        names = [f"{WHEEL}{i}" for i in range(chain.nodes)]
        self._bodies = np.array([model.body(name).id for name in names], dtype=np.intp)
        self._dofs = np.array([model.joint(name).dofadr[0] for name in names], dtype=np.intp)
        self._links = model.body_parentid[self._bodies]
        self._axles, self._contacts = model.body_quat, model.pair_solreffriction
        # By MuJoCo's formulas for `solref` and `solimp`: 2 / time constant, both over the last.
        self._own_damping = 2.0 / float(model.pair_solref[0, 0])
        self._scale = float(model.pair_solimp[0, 1])
        self._dampings = [self._own_damping] * chain.nodes
        self._most_lean = min(chain.tyre_half_width_m / chain.wheel_radius_m, 1.0)

    def roll(
        self, frictions_n: Sequence[float], yields: Sequence[float], normals: Sequence[Vector]
    ) -> None:
        """Set how wheels creep and lean in the next cycle, by where each presses most.

        Args:
            frictions_n: The most that friction bears there; 0 where a wheel touches nothing.
            yields: `efc_R` there.
            normals: Of the wall there.
        """
        most, speeds = self._own_damping, self._data.qvel[self._dofs].tolist()
        for i, (friction_n, share, rad_s) in enumerate(
            zip(frictions_n, yields, speeds, strict=True)
        ):
            rim_m_s = self._radius_m * abs(rad_s)
            holds, slides_m_s = self._scale * friction_n * share, SLIDING_SLIP * rim_m_s
            damping = holds / slides_m_s if 0.0 < holds < most * slides_m_s else most
            before = self._dampings[i] * exp(-rim_m_s * self._cycle_s / _RELAXES_M)
            self._dampings[i] = max(damping, before)
        # Numbers below 0 are stiffness and damping, and along a wall a contact has no stiffness.
        pairs = self._contacts.reshape(len(speeds), -1, 2)
        pairs[:] = -np.array(self._dampings)[:, None, None]
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
