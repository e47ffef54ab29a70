"""Forces between wheels and walls in MuJoCo, and the friction that each wheel has by its slip."""

from __future__ import annotations

import mujoco
import numpy as np

from pirate_sm.model.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.mujoco.names import LINK, OBSTACLE, WHEEL
from pirate_sm.simulation.physics import QuantityLayout

_FULL_SLIP = 1.5
"""Times the threshold speed, from which on the kinetic coefficient holds (dynamics of the thesis,
fig. 4-3, gives no number)."""


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
        model.geom_friction[self._geoms, 0] = self.static

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""
        self.static[wheel], self.kinetic[wheel] = static, kinetic

    def read(self) -> None:
        """Write press and grip after a cycle, and set each wheel's friction for the next one."""
        self._press[:] = 0.0
        self._grip[:] = 0.0
        slip = np.zeros(len(self._press))
        data, contact = self._data, self._data.contact
        forces, wheel_of = data.efc_force, self._wheel_of
        velocities: list[tuple[list[float], list[float], list[float]]] | None = None
        strongest = [0.0] * len(slip)
        pairs = contact.geom.tolist()
        for (one, other), address, frame in zip(
            pairs, contact.efc_address.tolist(), contact.frame.tolist(), strict=True
        ):
            # A contact's frame begins with the normal from the first body to the second.
            second = other in wheel_of
            wheel = wheel_of.get(other if second else one)
            if wheel is None or address < 0 or self._obstacle in (one, other):
                continue
            sign = 1.0 if second else -1.0
            force = forces[address : address + 3].tolist()
            velocities = velocities or self._motions()
            normal = [sign * each for each in frame[:3]]
            tangent = _cross(velocities[wheel][2], normal)
            self._press[wheel] += force[0]
            self._grip[wheel] += sign * (
                force[1] * _dot(frame[3:6], tangent) + force[2] * _dot(frame[6:], tangent)
            )
            if force[0] > strongest[wheel]:
                strongest[wheel] = force[0]
                slip[wheel] = self._slip(velocities[wheel], normal)
        share = np.clip(
            (slip / self._threshold_m_s - 1.0) / (_FULL_SLIP - 1.0), 0.0, 1.0
        )
        friction = self.static + share * (self.kinetic - self.static)
        self._model.geom_friction[self._geoms, 0] = friction

    def _motions(self) -> list[tuple[list[float], list[float], list[float]]]:
        """Return each wheel's turning rate, velocity of its middle, and axle."""
        data, bodies = self._data, self._bodies
        turning, moving = data.cvel[bodies, :3], data.cvel[bodies, 3:]
        arm = data.xpos[bodies] - data.subtree_com[self._root]
        middles = moving + np.cross(turning, arm)
        axles = data.xmat[bodies][:, 2::3]
        return list(zip(turning.tolist(), middles.tolist(), axles.tolist(), strict=True))

    def _slip(
        self, motion: tuple[list[float], list[float], list[float]], normal: list[float]
    ) -> float:
        """Return how fast the wheel's surface moves along the wall that it touches."""
        turning, moving, _ = motion
        spun = _cross(turning, normal)
        velocity = [v - self._radius_m * s for v, s in zip(moving, spun, strict=True)]
        off = _dot(velocity, normal)
        return sum((v - off * n) ** 2 for v, n in zip(velocity, normal, strict=True)) ** 0.5


def _dot(one: list[float], other: list[float]) -> float:
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def _cross(one: list[float], other: list[float]) -> list[float]:
    return [
        one[1] * other[2] - one[2] * other[1],
        one[2] * other[0] - one[0] * other[2],
        one[0] * other[1] - one[1] * other[0],
    ]
