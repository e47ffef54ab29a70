"""The physics of a chain in a planar pipe, by extended position-based dynamics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pirate_sm.core.geometry import Route, Vector, flat
from pirate_sm.core.options import USUAL, Fidelity
from pirate_sm.core.simulation import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.physics import StartPose
from pirate_sm.simulation.xpbd import columns, glide, kernel
from pirate_sm.simulation.xpbd.chain import ChainState
from pirate_sm.simulation.xpbd.chain_world import ChainWorld
from pirate_sm.simulation.xpbd.iterations import EFFORTS
from pirate_sm.simulation.xpbd.pipe_arrays import gravity_along, leg_rows, wall_rows

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
        quantities: Quantities after the last cycle, then the kernel's own.
    """

    _columns, _functions = columns, glide

    def __init__(
        self,
        chain: ChainBody,
        route: Route,
        friction: Friction,
        pose: StartPose,
        cycle_s: float,
        fidelity: Fidelity = USUAL,
    ) -> None:
        super().__init__(chain, friction, cycle_s)
        n = chain.nodes
        self.state = ChainState(n)
        self.quantities: Floats = np.zeros(
            (columns.OUT_PER_WHEEL + columns.OUT_OWN) * n + columns.OUT_SINGLE
        )
        self._route = route
        self._fill(chain, EFFORTS[fidelity], _FIELD_UT)
        self._world[columns.DEPTH] = route.pieces[0].diameter_m / 2.0
        self._legs = leg_rows(route)
        self.state.position[:] = [place[:2] for place in pose.places]
        self.state.bend[:] = pose.bends_rad
        self.state.motor[:] = pose.motors_rad
        self.state.roll[:] = pose.rolls_rad or (0.0, pose.roll_rad, pose.roll_rad)
        self._start(
            *(self.state.array[: 2 * n], self.state.array, self.duties, self.body),
            *(wall_rows(route), self._legs, self._world, self.quantities),
            *kernel.scratch_arrays(n),
        )

    @property
    def roll_angles(self) -> Floats:
        """Angle of the roll joint, then the roll of the parts ahead and behind, rad."""
        return self.state.roll

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
