"""What the kinematic physics in a plane and in space share."""

from __future__ import annotations

from types import ModuleType

from pirate_sm.simulation.arrays import Floats


class ChainWorld:
    """A chain in the arrays of a kernel.

    Attributes:
        body: The moving parts, `(wheels, BODY_COLUMNS)`.
    """

    body: Floats
    _columns: ModuleType
    _world: Floats

    def turn_roll_to(self, angle_rad: float) -> None:
        """Set a new target for the roll joint."""
        self._world[self._columns.ROLL_TARGET] = angle_rad

    def unblock(self) -> None:
        """Remove the obstacle."""
        self._world[self._columns.BLOCK_NODE] = -1

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        """Disable a wheel's motor and make the wheel drag with this torque."""
        self.body[wheel, self._columns.WHEEL_RATE] = 0.0
        self.body[wheel, self._columns.WHEEL_HOLD] = drag_nm
        self.body[wheel, self._columns.WHEEL_STALL] = drag_nm

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""
        self.body[wheel, self._columns.MU_STATIC] = static
        self.body[wheel, self._columns.MU_KINETIC] = kinetic

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        """Set the dry friction of the joint at a wheel."""
        self.body[wheel, self._columns.JOINT_FRICTION] = friction_nm
