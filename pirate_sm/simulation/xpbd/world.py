"""The physics of a chain in a planar pipe, by extended position-based dynamics."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pirate_sm.geometry.plane import flat
from pirate_sm.geometry.route import Route
from pirate_sm.geometry.space import Vector
from pirate_sm.model.fidelity import USUAL, Fidelity
from pirate_sm.model.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import own_call
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.physics import StartPose
from pirate_sm.simulation.xpbd import columns, kernel
from pirate_sm.simulation.xpbd.chain import ChainState, body_array
from pirate_sm.simulation.xpbd.chain_world import ChainWorld
from pirate_sm.simulation.xpbd.glide import glide, pass_cycles
from pirate_sm.simulation.xpbd.iterations import EFFORTS, STEP_S, Effort
from pirate_sm.simulation.xpbd.pipe_arrays import gravity_along, leg_rows, wall_rows

_CONTACT_COMPLIANCE_M_N = 1e-5  # 1e5 N/m; with 1000 N/m a clamped V snaps through the wall
_ANCHOR_M = 2e-4
# A horizontal magnetic field along the first leg and downwards, uT (central Europe).
_FIELD_UT = (20.0, 0.0, 44.0)


class World(ChainWorld):
    """A chain in a planar pipe; a :class:`~pirate_sm.simulation.physics.Physics`.

    Args:
        chain: The moving parts.
        route: The pipe, in a plane.
        friction: Friction between wheels and walls.
        pose: The pose at the start.
        cycle_s: Duration of a cycle.
        fidelity: How finely steps are solved.

    Attributes:
        state: Positions, velocities and angles.
        duties: Duties in force: of joints, then of wheels.
        quantities: Quantities after the last cycle, then the kernel's own.
    """

    _columns = columns

    def __init__(
        self,
        chain: ChainBody,
        route: Route,
        friction: Friction,
        pose: StartPose,
        cycle_s: float,
        fidelity: Fidelity = USUAL,
    ) -> None:
        n = chain.nodes
        self.body: Floats = body_array(chain, friction)
        self.state = ChainState(n)
        self.duties: Floats = np.zeros(2 * n)
        self.quantities: Floats = np.zeros(
            (columns.OUT_PER_WHEEL + columns.OUT_OWN) * n + columns.OUT_SINGLE
        )
        self._route = route
        self._steps = max(1, round(cycle_s / STEP_S))
        self._world = _constants(chain, route, cycle_s / self._steps, EFFORTS[fidelity])
        self._legs = leg_rows(route)
        self._arrays = (
            *(self.state.array, self.duties, self.body, wall_rows(route), self._legs),
            *(self._world, self.quantities, *kernel.scratch_arrays(n)),
        )
        self.state.position[:] = [place[:2] for place in pose.places]
        self.state.bend[:] = pose.bends_rad
        self.state.motor[:] = pose.motors_rad
        self.state.roll[:] = pose.rolls_rad or (0.0, pose.roll_rad, pose.roll_rad)
        self._glide, self._pass_cycles = own_call(glide), own_call(pass_cycles)
        # This fills in the quantities of the start pose; hardly any time passes.
        kernel.advance(*self._arrays, 1)

    def advance(self) -> None:
        """Simulate one cycle."""
        kernel.advance(*self._arrays, self._steps)

    @property
    def roll_angles(self) -> Floats:
        """Angle of the roll joint, then the roll of the parts ahead and behind, rad."""
        return self.state.roll

    def glide(self, *arrays: Any) -> None:
        """Let cycles pass; see :class:`~pirate_sm.simulation.gliding.protocol.GlidingPhysics`."""
        self._glide(*self._arrays, self._steps, *arrays)

    def pass_cycles(self, *arrays: Any) -> None:
        """Let cycles pass with the duties in force; see `glide`."""
        self._pass_cycles(*self._arrays, self._steps, *arrays)

    def places(self) -> Sequence[Vector]:
        """Return the centre of each wheel in the drawing of the pipe, m; z is 0."""
        return [(x, y, 0.0) for x, y in self.state.position.tolist()]

    def rolls(self) -> Sequence[float]:
        """Return the angle of the roll joint, then the roll of the parts ahead and behind, rad."""
        found: list[float] = self.state.roll.tolist()
        return found

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        """Put an obstacle in the way of one wheel; `ahead`: the obstacle is ahead of the wheel."""
        frame = self._route.frame_at(arc_m)
        sign = -1.0 if ahead else 1.0
        self._world[columns.BLOCK_NODE] = wheel
        self._world[columns.BLOCK_X], self._world[columns.BLOCK_Y] = flat(frame.origin)
        self._world[columns.BLOCK_NX] = sign * frame.ahead[0]
        self._world[columns.BLOCK_NY] = sign * frame.ahead[1]

    def turn_gravity(self, up: Vector) -> None:
        """Let gravity pull against this unit vector from now on."""
        self._legs[:, columns.L_GT :] = [gravity_along(piece, up) for piece in self._route.pieces]


def _constants(chain: ChainBody, route: Route, dt: float, effort: Effort) -> Floats:
    world = np.zeros(columns.WORLD_ENTRIES)
    world[columns.DT] = dt
    world[[columns.ITERATIONS, columns.LOOK, columns.PULL]] = effort
    world[columns.RADIUS] = chain.wheel_radius_m
    world[columns.HALF_THICKNESS] = chain.half_thickness_m
    world[columns.CONTACT_COMPLIANCE] = _CONTACT_COMPLIANCE_M_N
    world[columns.ANCHOR_MAX] = _ANCHOR_M
    world[columns.DEPTH] = route.pieces[0].diameter_m / 2.0
    world[columns.BLOCK_NODE] = -1
    world[columns.ROLL_LINK] = chain.roll_link
    world[columns.ROLL_RATE] = chain.roll_rate_rad_s
    world[columns.ROLL_STALL] = chain.roll_stall_nm
    world[columns.MAG_X : columns.MAG_Z + 1] = _FIELD_UT
    return world
