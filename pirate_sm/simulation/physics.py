"""The protocol of a physics: duties go in, quantities come out; and the chain that it moves.

The electronics, the defects and the surroundings of a simulated robot use only this protocol.
Positions are points in space; a planar physics has z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias, runtime_checkable

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import Route, Vector
from pirate_sm.core.models import Friction, Profile
from pirate_sm.simulation.arrays import Floats

# --- the chain -----------------------------------------------------------------------------------


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
        tyre_half_width_m: Half the width of every wheel.
        rolling_resistance: Of every wheel, over the normal force.
        spin_radius_m: Torque of friction against spinning on the spot, over the force of friction.
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
    tyre_half_width_m: float = 0.006
    rolling_resistance: float = 0.0
    spin_radius_m: float = 0.0014

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
        body.wheel_width / 2,
        profile.simulation.tyre.rolling_resistance,
        profile.simulation.tyre.spin_radius,
    )


def _motor_link(modules: Sequence[str], module: str, wheel: int) -> int:
    """Return the link with a wheel's motor: that of the board's module, else the one ahead."""
    near = [m for m in (wheel - 1, wheel) if 0 <= m < len(modules)]
    return next((m for m in near if modules[m] == module), near[0])


# --- the protocol --------------------------------------------------------------------------------


PER_WHEEL = (
    *("bend", "bend_torque", "bend_current", "wheel", "turned"),
    *("drive", "press", "arc", "grip"),
)
SINGLE = ("roll", "roll_current", "acc_x", "acc_y", "acc_z", "mag_x", "mag_y", "mag_z")


@dataclass(frozen=True)
class QuantityLayout:
    """The layout of the quantities of a chain of wheels in a physics' array.

    Per wheel: `bend`, the angle of the joint at that wheel; `bend_torque`, its torque;
    `bend_current`, its motor's share of the stall current; `wheel`, the wheel's angle; `turned`,
    the filtered difference of this angle; `drive`, the torque of its motor; `press`, the normal
    force of the walls; `grip`, the force along them; `arc`, the position along the pipe. For the
    robot: `roll`, the angle of the roll joint; `roll_current`, its motor's share of the stall
    current; `acc_x` .. `mag_z`, what an inertial unit measures along forward, side B and up. SI
    units.
    """

    wheels: int

    @property
    def size(self) -> int:
        """Number of values in the array."""
        return len(PER_WHEEL) * self.wheels + len(SINGLE)

    def at(self, quantity: str, wheel: int = 0) -> int:
        """Return the index of a quantity; for a quantity per wheel, that of the given wheel."""
        if quantity in PER_WHEEL:
            return PER_WHEEL.index(quantity) * self.wheels + wheel
        return len(PER_WHEEL) * self.wheels + SINGLE.index(quantity)

    def block(self, quantity: str) -> slice:
        """Return the slice with the values of all wheels."""
        return slice(self.at(quantity), self.at(quantity) + self.wheels)


@dataclass(frozen=True)
class StartPose:
    """The pose of the robot at the start of the run.

    Attributes:
        places: Centre of each wheel, m.
        bends_rad: Angle of the joint at each wheel.
        motors_rad: Motor-side angle of each of these joints; the difference winds up the spring.
        roll_rad: Roll of the whole robot against the plane of the pipe.
        rolls_rad: Angle of the roll joint, then the rolls of the parts ahead and behind against the
            pipe where they are, of a robot that is in the middle of a run; empty for one that
            begins, which lies straight.
        roll_motor_rad: Motor-side angle of the roll joint of such a robot.
    """

    places: tuple[Vector, ...]
    bends_rad: tuple[float, ...]
    motors_rad: tuple[float, ...]
    roll_rad: float = 0.0
    rolls_rad: tuple[float, ...] = ()
    roll_motor_rad: float = 0.0


class Physics(Protocol):
    """A robot's chain in a pipe, advanced by whole cycles of the bus.

    Nothing is global, so any number of them can exist at once. Equal calls give equal quantities to
    the last bit.
    """

    @property
    def duties(self) -> Floats:
        """Duties in force, `(2 * wheels,)`: of the joint at each wheel, then of each wheel.

        This is one array as long as the physics exists; others write to it.
        """

    @property
    def quantities(self) -> Floats:
        """Quantities after the last cycle, laid out by :class:`QuantityLayout`; it may be longer.

        This is one array as long as the physics exists. Before the first cycle it holds the
        quantities of the start pose. After the robot has left the pipe, others write to it.
        """

    def turn_roll_to(self, angle_rad: float) -> None:
        """Set a new target for the roll joint."""

    def advance(self) -> None:
        """Simulate one cycle."""

    def places(self) -> Sequence[Vector]:
        """Return the centre of each wheel, m."""

    def rolls(self) -> Sequence[float]:
        """Return the angle of the roll joint, then the roll of the parts ahead and behind, rad."""

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        """Put an obstacle in the way of one wheel; `ahead`: the obstacle is ahead of the wheel."""

    def unblock(self) -> None:
        """Remove the obstacle."""

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        """Disable a wheel's motor and make the wheel drag with this torque."""

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""

    def turn_gravity(self, up: Vector) -> None:
        """Let gravity pull against this unit vector from now on."""

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        """Set the dry friction of the joint at a wheel."""


MakePhysics: TypeAlias = Callable[[ChainBody, Route, Friction, StartPose, float], Physics]
"""Makes a physics from a chain, a route, friction, the start pose and the cycle, s."""


# --- cycles that pass in one call ----------------------------------------------------------------


@runtime_checkable
class GlidingPhysics(Protocol):
    """A physics with two compiled functions around its step.

    One calls :func:`~pirate_sm.simulation.gliding.cycle.may_begin` before the step and
    :func:`~pirate_sm.simulation.gliding.cycle.goes_on` after it, as long as both return true; the
    other :func:`~pirate_sm.simulation.gliding.cycle.may_pass` and
    :func:`~pirate_sm.simulation.gliding.cycle.passes_on`. They are all that a physics adds; see
    :mod:`pirate_sm.simulation.kinematic.kernel`.
    """

    @property
    def roll_angles(self) -> Floats:
        """Angle of the roll joint, then the roll of the parts ahead and behind, rad.

        This is one array as long as the physics exists.
        """

    def glide(self, *groups: Any) -> None:
        """Let cycles pass; the arguments: ``kinematic.kernel.glide``'s from ``place`` on."""

    def pass_cycles(self, *groups: Any) -> None:
        """Let cycles pass with the duties in force; as for ``kinematic.kernel.pass_cycles``."""
