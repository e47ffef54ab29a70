"""The moving parts of a robot, from its profile: a chain of wheels, links and joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pirate_sm.core.errors import UsageError
from pirate_sm.core.profile import Profile

# Assumed, not measured: enough damping that a free bend joint swings once.
JOINT_DAMPING_NMS_RAD = 0.02


@dataclass(frozen=True)
class WheelBody:
    """A wheel at a node of the chain, with its geared motor.

    Attributes:
        mass_kg: Mass of the wheel alone.
        motor_link: Index of the link that carries its motor, one of its two neighbours.
        rate_rad_s: No-load speed at full duty; 0 for a wheel without a working motor.
        stall_nm: Stall torque of the driven wheel.
        hold_nm: Torque that turns it against its gearbox at duty 0.
        dead_drag_nm: Drag torque after its motor has failed.
        rotor_inertia_kgm2: Moment of inertia of its motor's rotor, seen through the gears.
    """

    mass_kg: float
    motor_link: int
    rate_rad_s: float
    stall_nm: float
    hold_nm: float
    dead_drag_nm: float
    rotor_inertia_kgm2: float = 0.0


@dataclass(frozen=True)
class LinkBody:
    """A rigid link; half its mass is at each end (modules are point masses, thesis 3-4)."""

    length_m: float
    mass_kg: float


@dataclass(frozen=True)
class JointBody:
    """A bend joint: a self-locking motor behind a series spring.

    Attributes:
        stiffness_nm_rad: Stiffness of the spring at the joint.
        rate_rad_s: No-load speed at full duty; 0 for a joint without a motor.
        stall_nm: Stall torque at full duty.
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
    """The whole chain, from front to rear.

    Attributes:
        wheels: Wheels, at the nodes.
        links: Links between neighbouring wheels, one fewer than wheels.
        joints: Joint at each wheel, by index; a wheel without one is rigid.
        wheel_index: Index of each wheel by name.
        joint_index: Index of the wheel at each bend joint, by the joint's name.
        wheel_radius_m: Radius of every wheel.
        half_thickness_m: Half the thickness of the links' bodies.
        roll_link: Index of the link with the roll joint, -1 without.
        roll_rate_rad_s: No-load speed of the roll joint.
        roll_stall_nm: Stall torque of its motor.
        felt_over_s: Time constant of the accelerometer's smoothing: the time between its reports.
    """

    wheels: tuple[WheelBody, ...]
    links: tuple[LinkBody, ...]
    joints: Mapping[int, JointBody]
    wheel_index: Mapping[str, int]
    joint_index: Mapping[str, int]
    wheel_radius_m: float
    half_thickness_m: float
    roll_link: int = -1
    roll_rate_rad_s: float = 1.0
    roll_stall_nm: float = 1.0
    felt_over_s: float = 0.0

    def felt_share(self, cycle_s: float) -> float:
        """Return the share of a cycle in what the accelerometer shows after it."""
        return min(1.0, cycle_s / self.felt_over_s) if self.felt_over_s else 1.0

    @property
    def nodes(self) -> int:
        """Number of wheels."""
        return len(self.wheels)

    @property
    def length_m(self) -> float:
        """Length of the straight chain."""
        return sum(link.length_m for link in self.links)


def needed(value: float | None, motor: str, field: str) -> float:
    """Return a motor's number that only a simulator needs.

    Raises:
        UsageError: The profile does not have it.
    """
    if value is None:
        raise UsageError(f"motors.{motor} needs {field} to be simulated")
    return value


def chain_of(profile: Profile) -> ChainBody:
    """Return the chain that the profile describes.

    Raises:
        UsageError: The profile lacks a number that only a simulator needs.
    """
    body = profile.body
    wheels = {wheel.name: i for i, wheel in enumerate(body.wheels)}
    joints = {joint.name: wheels[joint.wheel] for joint in body.joints}
    modules = [link.module for link in body.links]
    made: dict[int, WheelBody] = {}
    springs: dict[int, JointBody] = {}
    roll_rate = roll_stall = 0.0
    stops = {joint.name: joint.end_stop for joint in body.joints}
    for board in profile.boards:
        for slot in board.slots:
            motor = profile.motors[slot.motor]
            if slot.wheel is not None:
                i = wheels[slot.wheel]
                made[i] = WheelBody(
                    body.wheels[i].mass,
                    _motor_link(modules, board.module, i),
                    needed(motor.no_load_speed, slot.motor, "no_load_speed"),
                    needed(motor.stall_torque, slot.motor, "stall_torque"),
                    needed(motor.hold_torque, slot.motor, "hold_torque"),
                    needed(motor.dead_drag, slot.motor, "dead_drag"),
                    motor.rotor_inertia or 0.0,
                )
            elif slot.joint is not None:
                springs[joints[slot.joint]] = JointBody(
                    needed(motor.stiffness, slot.motor, "stiffness"),
                    needed(motor.no_load_speed, slot.motor, "no_load_speed"),
                    needed(motor.stall_torque, slot.motor, "stall_torque"),
                    stops[slot.joint],
                    damping_nms_rad=JOINT_DAMPING_NMS_RAD,
                )
            elif slot.roll is not None:
                roll_rate = needed(motor.no_load_speed, slot.motor, "no_load_speed")
                roll_stall = needed(motor.stall_torque, slot.motor, "stall_torque")
    for i, wheel in enumerate(body.wheels):
        made.setdefault(i, WheelBody(wheel.mass, max(i - 1, 0), 0.0, 1.0, 0.0, 0.0))
    return ChainBody(
        tuple(made[i] for i in range(len(body.wheels))),
        tuple(LinkBody(link.length, link.mass) for link in body.links),
        springs,
        wheels,
        joints,
        body.wheel_radius,
        body.body_half_thickness,
        next((m for m, link in enumerate(body.links) if link.roll is not None), -1),
        roll_rate or 1.0,
        roll_stall or 1.0,
        profile.link.cycle * profile.messages_per_round,
    )


def _motor_link(modules: Sequence[str], module: str, wheel: int) -> int:
    """Return the link with a wheel's motor: that of the board's module, else the one ahead."""
    near = [m for m in (wheel - 1, wheel) if 0 <= m < len(modules)]
    return next((m for m in near if modules[m] == module), near[0])
