"""A chain and its state as arrays for the kernel."""

from __future__ import annotations

import math

import numpy as np

from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody, JointBody
from pirate_sm.simulation.xpbd import columns

RIGID = JointBody(stiffness_nm_rad=200.0, rate_rad_s=0.0, stall_nm=1.0, stop_rad=math.pi)


def body_array(chain: ChainBody, friction: Friction) -> Floats:
    """Return the chain as an array for the kernel, `(wheels, columns.BODY_COLUMNS)`."""
    n = chain.nodes
    body = np.zeros((n, columns.BODY_COLUMNS))
    for i, wheel in enumerate(chain.wheels):
        mass = wheel.mass_kg
        mass += sum(0.5 * chain.links[m].mass_kg for m in (i - 1, i) if 0 <= m < n - 1)
        joint = chain.joints.get(i, RIGID)
        body[i, : columns.LINK_LENGTH] = (
            1.0 / mass,
            friction.static,
            friction.kinetic,
            wheel.rate_rad_s,
            wheel.stall_nm,
            wheel.hold_nm,
            wheel.motor_link,
            joint.stiffness_nm_rad,
            joint.rate_rad_s,
            joint.stall_nm,
            joint.friction_nm,
            -joint.stop_rad,
            joint.stop_rad,
            joint.damping_nms_rad,
        )
        if i < n - 1:
            body[i, columns.LINK_LENGTH] = chain.links[i].length_m
    return body


class ChainState:
    """Views into the one array with the state of the chain.

    Attributes:
        array: The array for the kernel.
        position: `(wheels, 2)`, m.
        velocity: `(wheels, 2)`, m/s.
        motor: Motor-side angle of the joint at each wheel, rad.
        wheel: Angle of each wheel against its link, rad.
        bend: Angle of the joint at each wheel, rad.
        roll: Angle of the roll joint, roll of the front, roll of the rear part, rad.
    """

    def __init__(self, nodes: int) -> None:
        n = nodes
        self.array: Floats = np.zeros(columns.S_ROLL * n + 3)
        self.position = self.array[: 2 * n].reshape(n, 2)
        self.velocity = self.array[columns.S_VELOCITY * n : columns.S_MOTOR * n].reshape(n, 2)
        self.motor = self.array[columns.S_MOTOR * n : columns.S_WHEEL * n]
        self.wheel = self.array[columns.S_WHEEL * n : columns.S_BEND * n]
        self.bend = self.array[columns.S_BEND * n : columns.S_ANCHOR * n]
        self.roll = self.array[columns.S_ROLL * n :]
