"""The protocol of a physics: duties go in, quantities come out.

The electronics, the defects and the surroundings of a simulated robot use only this protocol.
Positions are points in space; a planar physics has z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from pirate_sm.core.geometry import Route, Vector
from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody

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
