"""What the kinematic physics in a plane and in space share."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import own_call
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.xpbd.chain import body_array
from pirate_sm.simulation.xpbd.iterations import STEP_S, Effort

# 1e5 N/m; with 1000 N/m a clamped V snaps through the wall. In space the ends of missions depend
# on it [measured with benchmarks.space].
_CONTACT_COMPLIANCE_M_N = 1e-5
_ANCHOR_M = 2e-4


class ChainWorld:
    """A chain in the arrays of a kernel.

    A kind of it names the module of the columns and that of the compiled functions.

    Args:
        chain: The moving parts.
        friction: Friction between wheels and walls.
        cycle_s: Duration of a cycle.

    Attributes:
        body: The moving parts, `(wheels, BODY_COLUMNS)`.
        duties: Duties in force: of joints, then of wheels.
    """

    _columns: ModuleType
    _functions: ModuleType

    def __init__(self, chain: ChainBody, friction: Friction, cycle_s: float) -> None:
        self.body: Floats = body_array(chain, friction)
        self.duties: Floats = np.zeros(2 * chain.nodes)
        self._felt = chain.felt_share(cycle_s)
        self._steps = max(1, round(cycle_s / STEP_S))
        self._world: Floats = np.zeros(self._columns.WORLD_ENTRIES)
        self._world[self._columns.DT] = cycle_s / self._steps

    def _fill(self, chain: ChainBody, effort: Effort, field_ut: tuple[float, ...]) -> None:
        """Fill in what the kernels must know of any pipe."""
        world, columns = self._world, self._columns
        world[[columns.ITERATIONS, columns.LOOK, columns.PULL]] = effort
        world[columns.RADIUS] = chain.wheel_radius_m
        world[columns.HALF_THICKNESS] = chain.half_thickness_m
        world[columns.CONTACT_COMPLIANCE] = _CONTACT_COMPLIANCE_M_N
        world[columns.ANCHOR_MAX] = _ANCHOR_M
        world[columns.BLOCK_NODE] = -1
        world[columns.ROLL_LINK] = chain.roll_link
        world[columns.ROLL_RATE] = chain.roll_rate_rad_s
        world[columns.ROLL_STALL] = chain.roll_stall_nm
        world[columns.MAG_X : columns.MAG_Z + 1] = field_ut

    def _start(self, centres: Floats, *arrays: Any) -> None:
        """Fill in the quantities of the start pose, in hardly any time.

        Args:
            centres: Those of the wheels, in the first of the arrays.
            arrays: What the kernel takes before the number of steps.
        """
        self._chain, self._centres = (*arrays, self._steps), centres
        self._glide = own_call(self._functions.glide)
        self._pass_cycles = own_call(self._functions.pass_cycles)
        self._world[self._columns.FELT] = 1.0
        self._functions.advance(*arrays, 1)
        self._world[self._columns.FELT] = self._felt

    def advance(self) -> None:
        """Simulate one cycle."""
        self._functions.advance(*self._chain)

    def glide(self, *groups: Any) -> None:
        """Let cycles pass; see :class:`~pirate_sm.simulation.gliding.protocol.GlidingPhysics`."""
        self._glide(self._chain, self._centres, *groups)

    def pass_cycles(self, *groups: Any) -> None:
        """Let cycles pass with the duties in force; see `glide`."""
        self._pass_cycles(self._chain, *groups)

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
