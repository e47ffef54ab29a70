"""The physics of a chain in round pipes in space, by extended position-based dynamics."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pirate_sm.core.geometry import GRAVITY_M_S2, Route, Vector
from pirate_sm.core.models import Friction
from pirate_sm.core.options import USUAL, Fidelity
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic.space import columns, kernel
from pirate_sm.simulation.kinematic.space.pipe_shape import shape_of
from pirate_sm.simulation.kinematic.world import EFFORTS, ChainWorld
from pirate_sm.simulation.physics import ChainBody, StartPose
from pirate_sm.simulation.start_pose import lying, normals_of

# --- the state -----------------------------------------------------------------------------------


class SpaceState:
    """Views into the one array with the state of the chain.

    Args:
        nodes: Number of wheels.

    Attributes:
        array: The array for the kernel.
        position: `(wheels, 3)`, m.
        velocity: `(wheels, 3)`, m/s.
        motor: Motor-side angle of the joint at each wheel, rad.
        wheel: Angle of each wheel against its link, rad.
        bend: Angle of the joint at each wheel, rad.
        normals: `(2, 3)`, unit normals of the planes of the parts ahead of and behind the roll
            joint.
        roll: Angle of the roll joint and of its motor, rad.
    """

    def __init__(self, nodes: int) -> None:
        n, last = nodes, columns.S_ROLL * nodes
        self.array: Floats = np.zeros(last + columns.ROLL_ENTRIES)
        self.position = self.array[: 3 * n].reshape(n, 3)
        self.velocity = self.array[columns.S_VELOCITY * n : columns.S_MOTOR * n].reshape(n, 3)
        self.motor = self.array[columns.S_MOTOR * n : columns.S_WHEEL * n]
        self.wheel = self.array[columns.S_WHEEL * n : columns.S_BEND * n]
        self.bend = self.array[columns.S_BEND * n : columns.S_ANCHOR * n]
        self.normals = self.array[last : last + columns.R_RATE].reshape(2, 3)
        self.roll = self.array[last + columns.R_ANGLE :]

    def take(
        self, pose: StartPose, places: Sequence[Vector], normals: tuple[Vector, Vector]
    ) -> None:
        """Put the chain into a pose whose wheels are at these places.

        Args:
            pose: The pose.
            places: Centre of each wheel, m.
            normals: Of the planes of the parts ahead of and behind the roll joint.
        """
        self.position[:] = places
        self.normals[:] = normals
        if pose.rolls_rad:
            self.roll[:] = (pose.rolls_rad[0], pose.roll_motor_rad)
        self.bend[:] = pose.bends_rad
        self.motor[:] = pose.motors_rad


# --- the physics ---------------------------------------------------------------------------------


# A horizontal magnetic field along the first leg and against its normal, uT (central Europe).
_FIELD_UT = (20.0, 0.0, -44.0)


class SpaceWorld(ChainWorld):
    """A chain in round pipes; a :class:`~pirate_sm.simulation.physics.Physics`.

    Args:
        chain: The moving parts.
        route: The way through the pipes.
        friction: Friction between wheels and walls.
        pose: The pose at the start.
        cycle_s: Duration of a cycle.
        fidelity: How finely steps are solved.

    Attributes:
        state: Positions, velocities and angles.
        quantities: Quantities after the last cycle, then the kernel's own.
    """

    _columns, _functions = columns, kernel

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
        self.state = SpaceState(n)
        own = columns.OUT_PER_WHEEL * n + columns.OUT_SINGLE
        self.quantities: Floats = np.zeros(own + columns.OUT_OWN)
        self._own = self.quantities[own:]
        self._route = route
        self._fill(chain, EFFORTS[fidelity], _FIELD_UT)
        half = min(chain.tyre_half_width_m / chain.wheel_radius_m, 1.0)
        self._world[columns.TYRE_EDGE] = math.sqrt(1.0 - half * half)
        link = self._fill_roll_joint(chain)
        self._gravity = self._world[columns.G_X : columns.G_Z + 1]
        self.turn_gravity(route.up)
        places = pose.places if pose.rolls_rad else lying(pose, chain, route)
        self.state.take(pose, places, normals_of(pose, route, link))
        shape = shape_of(route)
        self._start(
            pose,
            *(self.state.array[: 3 * n], self.state.array, self.duties, self.body, *shape),
            *(self._world, self.quantities),
            *kernel.scratch_arrays(n, len(shape.solids), len(shape.edges)),
        )

    def _fill_roll_joint(self, chain: ChainBody) -> int:
        """Fill in the roll joint; return its link.

        A chain without a roll joint has one that stands still, in the middle.
        """
        link = chain.roll_link if chain.roll_link >= 0 else (chain.nodes - 2) // 2
        if chain.roll_link < 0:
            self._world[columns.ROLL_RATE] = 0.0
        self._world[columns.ROLL_LINK] = link
        self._world[columns.INERTIA_FRONT] = _roll_inertia(chain, 0, link)
        self._world[columns.INERTIA_REAR] = _roll_inertia(chain, link + 1, chain.nodes - 1)
        self._world[columns.IMU_LINK] = max(chain.roll_link, 0)
        return link

    @property
    def roll_angles(self) -> Floats:
        """Angle of the roll joint, then the roll of the parts ahead and behind, rad."""
        return self._own[: columns.OUT_DEEPEST]

    def places(self) -> Sequence[Vector]:
        """Return the centre of each wheel in the drawing of the pipe, m."""
        return [(x, y, z) for x, y, z in self.state.position.tolist()]

    def rolls(self) -> Sequence[float]:
        """Return the angle of the roll joint, then the roll of the parts ahead and behind, rad."""
        found: list[float] = self.roll_angles.tolist()
        return found

    @property
    def deepest_m(self) -> float:
        """Return how deep a wheel or link has been in a wall so far, m."""
        return float(self._own[columns.OUT_DEEPEST])

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        """Put an obstacle in the way of one wheel; `ahead`: the obstacle is ahead of the wheel."""
        frame = self._route.frame_at(arc_m)
        sign = -1.0 if ahead else 1.0
        self._world[columns.BLOCK_NODE] = wheel
        self._world[columns.BLOCK_X : columns.BLOCK_Z + 1] = frame.origin
        self._world[columns.BLOCK_NX : columns.BLOCK_NZ + 1] = [sign * each for each in frame.ahead]

    def turn_gravity(self, up: Vector) -> None:
        """Let gravity pull against this unit vector from now on."""
        self._gravity[:] = [-GRAVITY_M_S2 * each for each in up]


def _roll_inertia(chain: ChainBody, first: int, last: int) -> float:
    """Return the moment of inertia of a straight part about its axis, kg m².

    It counts as a cylinder of the wheels' radius [assumed]. Half of a robot of 0.8 kg with wheels
    of 48 mm has 1.2e-4 kg m².
    """
    links = sum(chain.links[m].mass_kg for m in range(first, last))
    shared = chain.links[last if first == 0 else first - 1].mass_kg / 2
    wheels = sum(chain.wheels[i].mass_kg for i in range(first, last + 1))
    return 0.5 * (links + shared + wheels) * chain.wheel_radius_m**2
