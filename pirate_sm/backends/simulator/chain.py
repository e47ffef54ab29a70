"""A planar chain of wheels and links, and its state, as the arrays that the kernel takes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pirate_sm.backends.simulator import kernel
from pirate_sm.backends.simulator.arrays import Floats


@dataclass(frozen=True)
class WheelBody:
    """A wheel on a node of the chain and its geared motor.

    Attributes:
        mass_kg: Of the wheel alone.
        motor_link: Index of the link that its motor sits on, one of its two neighbours.
        rate_rad_s: Speed without load at full duty; 0 for a wheel without a working motor.
        stall_nm: Torque at which a driven wheel stands still.
        hold_nm: Torque that turns it against its gearbox at duty 0.
        dead_drag_nm: Torque with which it drags once its motor has failed.
    """

    mass_kg: float
    motor_link: int
    rate_rad_s: float
    stall_nm: float
    hold_nm: float
    dead_drag_nm: float


@dataclass(frozen=True)
class LinkBody:
    """A rigid link; half its mass goes to each end (modules are point masses, thesis 3-4)."""

    length_m: float
    mass_kg: float


@dataclass(frozen=True)
class JointBody:
    """A bend joint: a self-locking motor behind a series spring.

    Attributes:
        stiffness_nm_rad: Of the spring at the joint.
        rate_rad_s: Speed without load at full duty; 0 for a joint without a motor.
        stall_nm: Torque at which it stands still at full duty.
        stop_rad: End stops at plus and minus this angle.
        friction_nm: Dry friction in the joint.
        damping_nms_rad: Viscous friction in the joint.
    """

    stiffness_nm_rad: float
    rate_rad_s: float
    stall_nm: float
    stop_rad: float
    friction_nm: float = 0.0
    damping_nms_rad: float = 0.02


@dataclass(frozen=True)
class ChainBody:
    """The whole chain, front to rear.

    Attributes:
        wheels: Wheels, on the nodes.
        links: Links between neighbouring wheels, one fewer.
        joints: Joint at each wheel by index; a node without one stays rigid.
        wheel_radius_m: Of every wheel.
        half_thickness_m: Of the links' bodies.
        roll_link: Link with a roll joint inside, -1 without.
        roll_rate_rad_s: Speed of the roll joint without load.
        roll_stall_nm: Torque at which its motor stands still.
    """

    wheels: tuple[WheelBody, ...]
    links: tuple[LinkBody, ...]
    joints: Mapping[int, JointBody]
    wheel_radius_m: float
    half_thickness_m: float
    roll_link: int = -1
    roll_rate_rad_s: float = 1.0
    roll_stall_nm: float = 1.0

    @property
    def nodes(self) -> int:
        """Number of wheels."""
        return len(self.wheels)


RIGID = JointBody(stiffness_nm_rad=200.0, rate_rad_s=0.0, stall_nm=1.0, stop_rad=math.pi)


@dataclass(frozen=True)
class Friction:
    """Coefficients between wheel and wall."""

    static: float
    kinetic: float


def body_array(chain: ChainBody, friction: tuple[Friction, ...]) -> Floats:
    """The chain as the kernel takes it, `(wheels, kernel.BODY_COLUMNS)`."""
    n = chain.nodes
    body = np.zeros((n, kernel.BODY_COLUMNS))
    for i, wheel in enumerate(chain.wheels):
        mass = wheel.mass_kg
        mass += sum(0.5 * chain.links[m].mass_kg for m in (i - 1, i) if 0 <= m < n - 1)
        joint = chain.joints.get(i, RIGID)
        body[i, : kernel.LINK_LENGTH] = (
            1.0 / mass,
            friction[i].static,
            friction[i].kinetic,
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
            body[i, kernel.LINK_LENGTH] = chain.links[i].length_m
    return body


class ChainState:
    """Views into the one array that holds everything that moves.

    Attributes:
        array: What the kernel takes.
        position: `(wheels, 2)`, m.
        velocity: `(wheels, 2)`, m/s.
        motor: Motor-side angle of the joint at each wheel, rad.
        wheel: Angle of each wheel against its link, rad.
        bend: Angle of the joint at each wheel, rad.
        roll: Angle of the roll joint, roll of the front, roll of the rear part, rad.
    """

    def __init__(self, nodes: int) -> None:
        n = nodes
        self.array: Floats = np.zeros(kernel.S_ROLL * n + 3)
        self.position = self.array[: 2 * n].reshape(n, 2)
        self.velocity = self.array[kernel.S_VELOCITY * n : kernel.S_MOTOR * n].reshape(n, 2)
        self.motor = self.array[kernel.S_MOTOR * n : kernel.S_WHEEL * n]
        self.wheel = self.array[kernel.S_WHEEL * n : kernel.S_BEND * n]
        self.bend = self.array[kernel.S_BEND * n : kernel.S_ANCHOR * n]
        self.roll = self.array[kernel.S_ROLL * n :]


@dataclass(frozen=True)
class Layout:
    """Where each quantity of a chain of so many wheels stands in the kernel's output.

    Per wheel: `bend`, `bend_torque`, `bend_current` (share of the stall current) of the joint at
    that wheel; `wheel` its angle, `turned` the filtered difference of it, `drive` the torque of
    its motor, `press` the normal force, `arc` the place in the pipe, `side` the offset towards
    side A, `leg` the number of the leg, `grip` the force along the wall. Single ones: `roll`,
    `roll_current`, `acc_x` .. `mag_z`. SI units.
    """

    wheels: int

    @property
    def size(self) -> int:
        """Length of the output array."""
        return len(kernel.PER_WHEEL) * self.wheels + len(kernel.SINGLE)

    def at(self, quantity: str, wheel: int = 0) -> int:
        """Index of a quantity, for those per wheel of the given wheel."""
        if quantity in kernel.PER_WHEEL:
            return kernel.PER_WHEEL.index(quantity) * self.wheels + wheel
        return len(kernel.PER_WHEEL) * self.wheels + kernel.SINGLE.index(quantity)

    def block(self, quantity: str) -> slice:
        """Where the values of all wheels stand."""
        return slice(self.at(quantity), self.at(quantity) + self.wheels)
