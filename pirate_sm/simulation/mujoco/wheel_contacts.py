"""Forces between wheels and walls in MuJoCo, and the friction that each wheel has by its slip."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

import mujoco
import numpy as np

from pirate_sm.core.geometry import Vector, crossed, dot
from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.mujoco.names import LINK, OBSTACLE, WHEEL
from pirate_sm.simulation.physics import QuantityLayout

_FULL_SLIP = 1.5
"""From this multiple of the threshold speed on the kinetic coefficient holds; the thesis's fig. 4-3
gives no number."""

_REACHED = 0.99
"""Share of the friction from which on it is exhausted."""


class _Motion(NamedTuple):
    """How a wheel turns, how its middle moves, and where its axle points."""

    turning: Vector
    moving: Vector
    axle: Vector


class WheelContacts:
    """Reads the forces of the walls on the wheels and gives each wheel the friction of its slip.

    The cone's coefficient is static up to the threshold of the slip speed and falls to the kinetic
    one at 1.5 times that speed (thesis fig. 4-3); within the cone, MuJoCo lets a wheel stick.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        friction: Of every wheel.
        quantities: Where the quantities are written.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: ChainBody,
        friction: Friction,
        quantities: Floats,
    ) -> None:
        self._model, self._data = model, data
        n, layout = chain.nodes, QuantityLayout(chain.nodes)
        self._press = quantities[layout.block("press")]
        self._grip = quantities[layout.block("grip")]
        self._bodies = np.array([model.body(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._geoms = np.array([model.geom(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._wheel_of = {int(geom): i for i, geom in enumerate(self._geoms)}
        self._root = model.body(f"{LINK}0").id
        self._obstacle = int(model.body(OBSTACLE).geomadr[0])
        self._radius_m = chain.wheel_radius_m
        self.static, self.kinetic = np.zeros(n), np.zeros(n)
        self._threshold_m_s = friction.threshold
        for wheel in range(n):
            self.let_grip(wheel, friction.static, friction.kinetic)
        # A wheel that slides with little force hops: between two hops it slides on.
        self._slips = np.zeros(n)
        self._friction: Floats = self.static.copy()
        model.geom_friction[self._geoms, 0] = self.static

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""
        self.static[wheel], self.kinetic[wheel] = static, kinetic

    def read(self) -> None:
        """Write press and grip after a cycle, and set each wheel's friction for the next one."""
        n = len(self.static)
        press, grip, strongest = [0.0] * n, [0.0] * n, [0.0] * n
        contact, forces = self._data.contact, self._data.efc_force
        motions: list[_Motion] = []
        for (one, other), address, frame in zip(
            contact.geom.tolist(), contact.efc_address.tolist(), contact.frame.tolist(), strict=True
        ):
            # A contact's frame begins with the normal from the first body to the second.
            second = other in self._wheel_of
            wheel = self._wheel_of.get(other if second else one)
            if wheel is None or address < 0 or self._obstacle in (one, other):
                continue
            motions = motions or self._motions()
            push, first_n, second_n = forces[address : address + 3].tolist()
            sign = 1.0 if second else -1.0
            normal = (sign * frame[0], sign * frame[1], sign * frame[2])
            tangent = crossed(motions[wheel].axle, normal)
            along = first_n * dot(frame[3:6], tangent) + second_n * dot(frame[6:], tangent)
            press[wheel] += push
            grip[wheel] += sign * along
            if push > strongest[wheel]:
                strongest[wheel] = push
                # A wheel that sticks creeps a little; it slips where its friction is exhausted.
                slips = hypot(first_n, second_n) >= _REACHED * self._friction[wheel] * push
                self._slips[wheel] = self._slip(motions[wheel], normal) if slips else 0.0
        self._press[:] = press
        self._grip[:] = grip
        self._set_friction()

    def _set_friction(self) -> None:
        beyond = self._slips / self._threshold_m_s - 1.0
        share = np.clip(beyond / (_FULL_SLIP - 1.0), 0.0, 1.0)
        friction = self.static + share * (self.kinetic - self.static)
        self._friction = friction
        self._model.geom_friction[self._geoms, 0] = friction

    def _motions(self) -> list[_Motion]:
        """Return how each wheel moves."""
        data, bodies = self._data, self._bodies
        x, y, z = data.subtree_com[self._root].tolist()
        rows = zip(
            data.cvel[bodies].tolist(),
            data.xpos[bodies].tolist(),
            data.xmat[bodies].tolist(),
            strict=True,
        )
        found = []
        for (a, b, c, u, v, w), (px, py, pz), axes in rows:
            arm = (px - x, py - y, pz - z)
            turning = crossed((a, b, c), arm)
            moving = (u + turning[0], v + turning[1], w + turning[2])
            found.append(_Motion((a, b, c), moving, (axes[2], axes[5], axes[8])))
        return found

    def _slip(self, motion: _Motion, normal: Vector) -> float:
        """Return how fast the wheel's surface moves along the wall that it touches, m/s."""
        (sx, sy, sz), (vx, vy, vz) = crossed(motion.turning, normal), motion.moving
        r = self._radius_m
        surface = (vx - r * sx, vy - r * sy, vz - r * sz)
        off = dot(surface, normal)
        return float(max(dot(surface, surface) - off * off, 0.0) ** 0.5)
