"""What the simulation asks of a physics, whichever it is: duties go in, quantities come out.

The electronics, the defects and the surroundings of a simulated robot know the physics by this
protocol only. Places are points of space; a planar physics gives z = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from pirate_sm.geometry.route import Route
from pirate_sm.geometry.space import Vector
from pirate_sm.model.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody

PER_WHEEL = (
    *("bend", "bend_torque", "bend_current", "wheel", "turned"),
    *("drive", "press", "arc", "grip"),
)
SINGLE = ("roll", "roll_current", "acc_x", "acc_y", "acc_z", "mag_x", "mag_y", "mag_z")


@dataclass(frozen=True)
class QuantityLayout:
    """Where each quantity of a chain of so many wheels stands in a physics' array of quantities.

    Per wheel: `bend` the angle of the joint at that wheel, `bend_torque` the torque that it bears,
    `bend_current` its motor's share of the stall current; `wheel` the wheel's angle, `turned` the
    filtered difference of it, `drive` the torque of its motor; `press` the normal force of the
    walls, `grip` the force along them, `arc` the place along the pipe. Of the robot: `roll` the
    angle of the roll joint, `roll_current` its motor's share of the stall current, `acc_x` ..
    `mag_z` what an inertial unit feels along forward, side B and up. SI units.
    """

    wheels: int

    @property
    def size(self) -> int:
        """How many numbers there are."""
        return len(PER_WHEEL) * self.wheels + len(SINGLE)

    def at(self, quantity: str, wheel: int = 0) -> int:
        """Return the index of a quantity, for those per wheel of the given wheel."""
        if quantity in PER_WHEEL:
            return PER_WHEEL.index(quantity) * self.wheels + wheel
        return len(PER_WHEEL) * self.wheels + SINGLE.index(quantity)

    def block(self, quantity: str) -> slice:
        """Return where the values of all wheels stand."""
        return slice(self.at(quantity), self.at(quantity) + self.wheels)


@dataclass(frozen=True)
class StartPose:
    """How the robot stands when the run begins.

    Attributes:
        places: Middle of each wheel, m.
        bends_rad: Angle of the joint at each wheel.
        motors_rad: Motor side of each of these joints, off by what the spring is wound up.
        roll_rad: Roll of the whole robot against the plane of the pipe.
    """

    places: tuple[Vector, ...]
    bends_rad: tuple[float, ...]
    motors_rad: tuple[float, ...]
    roll_rad: float = 0.0


class Physics(Protocol):
    """A robot's chain in a pipe, moved by whole cycles of the bus.

    Nothing of it is global: any number may be alive at once. Equal calls give equal quantities to
    the last bit.
    """

    @property
    def duties(self) -> Floats:
        """Duties in force, `(2 * wheels,)`: of the joint at each wheel, then of each wheel.

        The array is the same for as long as the physics lives; others write to it.
        """

    @property
    def quantities(self) -> Floats:
        """Quantities after the last cycle, laid out by :class:`QuantityLayout`; it may be longer.

        The array is the same for as long as the physics lives, and holds the quantities of the
        start pose before the first cycle. Once nothing moves any more, others write to it.
        """

    def turn_roll_to(self, angle_rad: float) -> None:
        """Give the roll joint a new target."""

    def advance(self) -> None:
        """Let one cycle pass."""

    def places(self) -> Sequence[Vector]:
        """Return where the middle of each wheel is, m."""

    def rolls(self) -> Sequence[float]:
        """Return the angle of the roll joint, then the roll of the part ahead and behind, rad."""

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        """Put an obstacle in the way of one wheel; `ahead`: the wheel is before it."""

    def unblock(self) -> None:
        """Take the obstacle away."""

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        """Let a wheel turn by its motor no more, and drag with this torque."""

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""

    def turn_gravity(self, up: Vector) -> None:
        """Let gravity pull against this unit vector from now on."""

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        """Give the joint at a wheel so much dry friction."""


MakePhysics: TypeAlias = Callable[[ChainBody, Route, Friction, StartPose, float], Physics]
"""Puts a chain into a pipe, with a friction and in a start pose; the last is the cycle, s."""
