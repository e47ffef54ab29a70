"""The kinematic physics: a chain in a planar pipe, and what it shares with the one in space."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from pirate_sm.core.geometry import GRAVITY_M_S2, Piece, Route, Section, Vector, flat, walls
from pirate_sm.core.models import Friction
from pirate_sm.core.options import USUAL, Fidelity
from pirate_sm.simulation import digitizing
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.kinematic import columns, kernel
from pirate_sm.simulation.kinematic.settling import SETTLING_S, settle
from pirate_sm.simulation.machine_code import is_kept, own_call
from pirate_sm.simulation.physics import ChainBody, JointBody, Physics, StartPose

# --- the chain in arrays -------------------------------------------------------------------------


RIGID = JointBody(stiffness_nm_rad=200.0, rate_rad_s=0.0, stall_nm=1.0, stop_rad=math.pi)


def body_array(chain: ChainBody, friction: Friction) -> Floats:
    """Return the chain as an array for the kernel, `(wheels, columns.BODY_COLUMNS)`."""
    n = chain.nodes
    body = np.zeros((n, columns.BODY_COLUMNS))
    for i, wheel in enumerate(chain.wheels):
        mass = wheel.mass_kg
        mass += sum(0.5 * chain.links[m].mass_kg for m in (i - 1, i) if 0 <= m < n - 1)
        joint = chain.joints.get(i, RIGID)
        body[i, : columns.LINK_LENGTH] = (
            1.0 / mass,
            friction.static,
            friction.kinetic,
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
            body[i, columns.LINK_LENGTH] = chain.links[i].length_m
    return body


class ChainState:
    """Views into the one array with the state of the chain.

    Attributes:
        array: The array for the kernel.
        position: `(wheels, 2)`, m.
        velocity: `(wheels, 2)`, m/s.
        motor: Motor-side angle of the joint at each wheel, rad.
        wheel: Angle of each wheel against its link, rad.
        bend: Angle of the joint at each wheel, rad.
        roll: Angle of the roll joint, roll of the front, roll of the rear part, rad.
    """

    def __init__(self, nodes: int) -> None:
        n = nodes
        self.array: Floats = np.zeros(columns.S_ROLL * n + 3)
        self.position = self.array[: 2 * n].reshape(n, 2)
        self.velocity = self.array[columns.S_VELOCITY * n : columns.S_MOTOR * n].reshape(n, 2)
        self.motor = self.array[columns.S_MOTOR * n : columns.S_WHEEL * n]
        self.wheel = self.array[columns.S_WHEEL * n : columns.S_BEND * n]
        self.bend = self.array[columns.S_BEND * n : columns.S_ANCHOR * n]
        self.roll = self.array[columns.S_ROLL * n :]


# --- steps ---------------------------------------------------------------------------------------


STEP_S = 0.002


class Effort(NamedTuple):
    """What is done for the steps.

    Attributes:
        iterations: How often each step is solved again.
        look: For how many steps directions, and what touches what, are kept.
        pull: The iteration in which the springs of the joints first act, from 0. They are soft
            beside links and walls.
    """

    iterations: int
    look: int
    pull: int


EFFORTS: dict[Fidelity, Effort] = {USUAL: Effort(4, 1, 0), "fast": Effort(2, 4, 1)}
"""Two iterations are the fewest that may be had: with one, a bend from below takes 3.5 times as
long. What fast costs in accuracy is printed by `python -m benchmarks.fidelity`.
"""


def notice_of(fidelity: Fidelity) -> str:
    """Return what a person must know of a run with this fidelity; empty if nothing."""
    if fidelity == USUAL:
        return ""
    coarse, usual = EFFORTS[fidelity], EFFORTS[USUAL]
    return (
        f"{fidelity}: {coarse.iterations} of {usual.iterations} iterations in each step of the "
        f"simulator, a look at the walls in every {coarse.look}th; the documentation's page on it "
        "says what that costs"
    )


# --- in a plane and in space ---------------------------------------------------------------------


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
    _gravity: Floats
    quantities: Floats

    def __init__(self, chain: ChainBody, friction: Friction, cycle_s: float) -> None:
        self.body: Floats = body_array(chain, friction)
        self.duties: Floats = np.zeros(2 * chain.nodes)
        self._felt, self._resistance = chain.felt_share(cycle_s), chain.rolling_resistance
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

    def _start(self, pose: StartPose, centres: Floats, *arrays: Any) -> None:
        """Fill in the quantities of the start pose: those of a step that is taken back.

        Args:
            pose: The pose; of a robot that begins a run, its clamps settle first.
            centres: Those of the wheels, in the first of the arrays.
            arrays: What the kernel takes before the number of steps.
        """
        self._chain, self._centres = (*arrays, self._steps), centres
        self._glide = own_call(self._functions.glide)
        self._pass_cycles = own_call(self._functions.pass_cycles)
        state = arrays[0]
        if any(pose.motors_rad) and not pose.rolls_rad:
            cycles = round(SETTLING_S / STEP_S / self._steps)
            settle(self.advance, cycles, self._columns, state, self.body, self._gravity)
        self._world[self._columns.ROLLING_RESISTANCE] = self._resistance
        before = state.copy()
        self._world[self._columns.FELT] = 1.0
        self._functions.advance(*arrays, 1)
        self._world[self._columns.FELT] = self._felt
        state[:] = before
        n = len(self.body)
        self.quantities[3 * n : 5 * n] = 0.0  # the wheels have not turned yet

    def advance(self) -> None:
        """Simulate one cycle."""
        self._functions.advance(*self._chain)

    def glide(self, *groups: Any) -> None:
        """Let cycles pass; see :class:`~pirate_sm.simulation.physics.GlidingPhysics`."""
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


# --- the pipe in arrays --------------------------------------------------------------------------


def leg_rows(route: Route) -> Floats:
    """Return the pieces as an array for the kernel, `(pieces, columns.LEG_COLUMNS)`."""
    return np.array([_leg_row(route, piece) for piece in route.pieces])


def wall_rows(route: Route) -> Floats:
    """Return the walls of both sides for the kernel, `(2 * pieces, columns.WALL_COLUMNS)`."""
    pieces, both = route.pieces, walls(route)
    rows = np.zeros((2 * len(pieces), columns.WALL_COLUMNS))
    for i, piece in enumerate(pieces):
        for side, wall in enumerate(both):
            (x0, y0), (x1, y1) = wall[i], wall[i + 1]
            sign = -1.0 if side == 0 else 1.0
            tx, ty = flat(piece.frame.ahead)
            row = rows[2 * i + side]
            row[:7] = (x0, y0, tx, ty, math.hypot(x1 - x0, y1 - y0), -ty * sign, tx * sign)
            if piece.bend is None:
                continue
            inner = (piece.bend.angle_rad > 0) == (side == 0)
            nx, ny = flat(pieces[i + 1].frame.ahead)
            bisector = (sign * (-ty - ny), sign * (tx + nx))
            norm = math.hypot(*bisector)
            row[7:] = (float(inner), nx, ny, bisector[0] / norm, bisector[1] / norm)
    return rows


def gravity_along(piece: Piece, up: Vector) -> tuple[float, ...]:
    """Return gravity along a piece, towards side A and along the normal of the plane, m/s²."""
    (tx, ty), (up_x, up_y, up_z) = flat(piece.frame.ahead), up
    against = (up_x * tx + up_y * ty, up_y * tx - up_x * ty, up_z)
    return tuple(-GRAVITY_M_S2 * each for each in against)


def _leg_row(route: Route, piece: Piece) -> tuple[float, ...]:
    """Return a piece, and gravity in its directions."""
    ahead, gravity = flat(piece.frame.ahead), gravity_along(piece, route.up)
    return (*flat(piece.frame.origin), *ahead, piece.length_m, piece.arc_m, *gravity)


# --- in a plane ----------------------------------------------------------------------------------


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
        self._gravity = self._legs[:, columns.L_GT :]
        self._start(
            pose,
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
        self._gravity[:] = [gravity_along(piece, up) for piece in self._route.pieces]


# --- the physics for a pipe ----------------------------------------------------------------------


def kinematic(
    chain: ChainBody,
    route: Route,
    friction: Friction,
    pose: StartPose,
    cycle_s: float,
    fidelity: Fidelity = USUAL,
) -> Physics:
    """Return the physics in a plane for bars, and in space for a round pipe."""
    if route.pieces[0].section == "bars":
        return World(chain, route, friction, pose, cycle_s, fidelity)
    from pirate_sm.simulation.kinematic.space.space_world import SpaceWorld

    return SpaceWorld(chain, route, friction, pose, cycle_s, fidelity)


def is_compiled(section: Section) -> bool:
    """Return whether a simulation can start at once; if not, its first call takes seconds."""
    functions: list[Callable[..., Any]] = [kernel.advance, kernel.glide, digitizing.digitize]
    if section == "round":
        from pirate_sm.simulation.kinematic.space import kernel as kernel_in_space

        functions[:2] = kernel_in_space.advance, kernel_in_space.glide
    return all(map(is_kept, functions))
