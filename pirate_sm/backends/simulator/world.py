"""The simulated world: a machine in a pipe, moved by setpoints in whole cycles."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pirate_sm.backends.simulator import kernel
from pirate_sm.backends.simulator.arrays import Floats, Words
from pirate_sm.backends.simulator.chain import ChainState, Friction, Layout, body_array
from pirate_sm.backends.simulator.geometry import Pipe
from pirate_sm.backends.simulator.machine import ROLL, Machine
from pirate_sm.errors import UsageError
from pirate_sm.geometry.clamping import span_m
from pirate_sm.geometry.plane import flat
from pirate_sm.geometry.space import GRAVITY_M_S2

STEP_S = 0.002
_ITERATIONS = 4
_CONTACT_COMPLIANCE_M_N = 1e-5  # 1e5 N/m; with 1000 N/m a clamped V toggles through the wall
_ANCHOR_M = 2e-4
# A horizontal magnetic field along the first leg and downwards, uT (central Europe).
_FIELD_UT = (20.0, 0.0, 44.0)
# Beyond this distance from the pipe's open end, a robot that has left it lies somewhere.
_GONE_M = 0.4


@dataclass(frozen=True)
class StartPose:
    """How the robot stands when the run begins.

    Attributes:
        arc_m: Place of the first wheel along the pipe.
        duties: Duty that each bend joint was wound up with, by the wheel it sits at; empty for
            a robot that is straight and unclamped.
        roll_rad: Roll of the whole robot against the plane of the pipe.
    """

    arc_m: float
    duties: dict[int, float]
    roll_rad: float = 0.0


class World:
    """A machine in a pipe; `advance` lets cycles pass.

    Attributes:
        pipe: Where it is.
        machine: What it is.
        layout: Where quantities stand in `out`.
        state: Everything that moves.
        out: Quantities after the last cycle, SI.
        raw: Counts of every channel when its board last reported.
        command: Duties in force, of joints, then of wheels.
        time_s: How much time has passed.
        gone: Whether the robot has left the pipe for good.
    """

    def __init__(
        self,
        machine: Machine,
        pipe: Pipe,
        friction: Friction,
        pose: StartPose,
        *,
        cycle_s: float,
        seed: int,
    ) -> None:
        n = machine.chain.nodes
        self.pipe = pipe
        self.machine = machine
        self.layout = Layout(n)
        self._arc_block = self.layout.block("arc")
        self.body: Floats = body_array(machine.chain, (friction,) * n)
        self.state = ChainState(n)
        self.command: Floats = np.zeros(2 * n)
        self.out: Floats = np.zeros(self.layout.size)
        self.raw: Floats = np.zeros(len(machine.channels))
        self.time_s = 0.0
        self.gone = False
        self._channels = machine.channels.copy()
        self._rng: Words = np.array([seed], dtype=np.uint64)
        self._steps = max(1, round(cycle_s / STEP_S))
        self._step_s = cycle_s / self._steps
        self._world = _constants(machine, pipe, self._step_s)
        self._arrays = (
            self.state.array, self.command, self.body, pipe.wall_array, pipe.leg_array,
            self._world, self._channels, self.out, self.raw, self._rng,
        )  # fmt: skip
        _place(self.state, machine, pipe, pose)
        self.settle()

    @property
    def nodes(self) -> int:
        """Number of wheels."""
        return self.layout.wheels

    def settle(self) -> None:
        """The quantities are those of the present positions; hardly any time has passed."""
        self._run(1, 0, len(self.raw))
        self.time_s = 0.0

    def set_values(self, values: Sequence[float]) -> None:
        """The setpoints, one per slot, are in force.

        Args:
            values: Duty cycles -1..1 and angles in rad, as the profile says.
        """
        for route, value in zip(self.machine.routes, values, strict=True):
            if route.command >= 0:
                self.command[route.command] = value
            elif route.command == ROLL:
                self._world[kernel.ROLL_TARGET] = value

    def refusal(self, values: Sequence[float]) -> str:
        """Why the setpoints cannot be taken; empty when they can."""
        if len(values) != len(self.machine.routes):
            return f"{len(values)} values for {len(self.machine.routes)} slots"
        for index, (route, value) in enumerate(zip(self.machine.routes, values, strict=True)):
            slack = 0.5 * route.step
            if not route.low - slack <= value <= route.high + slack:
                return f"slot {index}: {value} is outside {route.low:g}..{route.high:g}"
        return ""

    def advance(self, first: int, last: int) -> None:
        """One cycle has passed and the channels from `first` to before `last` are fresh."""
        if not self.gone:
            self._run(self._steps, first, last)
            return
        self.time_s += self._steps * self._step_s
        kernel.read_channels(self._channels, first, last, self.out, self.raw, self._rng)

    def values(self, quantity: str) -> list[float]:
        """A quantity of every wheel after the last cycle, see `chain.Layout`."""
        found: list[float] = self.out[self.layout.block(quantity)].tolist()
        return found

    def arcs(self) -> list[float]:
        """Return where each wheel is along the pipe, m."""
        found: list[float] = self.out[self._arc_block].tolist()
        return found

    def value(self, quantity: str) -> float:
        """A quantity that the robot has one of."""
        return float(self.out[self.layout.at(quantity)])

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        """An obstacle stands in the way of one wheel; `ahead` = the wheel is before it."""
        sign = -1.0 if ahead else 1.0
        self._world[kernel.BLOCK_NODE] = wheel
        frame = self.pipe.frame_at(arc_m)
        self._world[kernel.BLOCK_X], self._world[kernel.BLOCK_Y] = flat(frame.origin)
        self._world[kernel.BLOCK_NX] = sign * frame.ahead[0]
        self._world[kernel.BLOCK_NY] = sign * frame.ahead[1]

    def unblock(self) -> None:
        """No obstacle stands anywhere."""
        self._world[kernel.BLOCK_NODE] = -1

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        """A wheel no longer turns by its motor, and drags with this torque."""
        self.body[wheel, kernel.WHEEL_RATE] = 0.0
        self.body[wheel, kernel.WHEEL_HOLD] = drag_nm
        self.body[wheel, kernel.WHEEL_STALL] = drag_nm

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        """The joint at a wheel has dry friction."""
        self.body[wheel, kernel.JOINT_FRICTION] = friction_nm

    def mute_wheel(self, wheel: int) -> None:
        """Every channel about a wheel shows zero."""
        rows = self._rows_of(("wheel", "turned", "drive"), (wheel,))
        self._channels[rows, kernel.C_GAIN : kernel.C_SIGMA + 1] = 0.0

    def restart_boards(self) -> None:
        """All duties are zero, the roll joint stays, and incremental encoders begin at zero."""
        self.command[:] = 0.0
        self._world[kernel.ROLL_TARGET] = self.state.roll[0]
        for row in self._rows_of(("wheel", "roll"), range(self.nodes)):
            source = int(self._channels[row, kernel.C_SOURCE])
            counts = self.out[source] * self._channels[row, kernel.C_GAIN]
            self._channels[row, kernel.C_OFFSET] = -counts

    def _rows_of(self, quantities: Sequence[str], wheels: Iterable[int]) -> list[int]:
        """Rows of the channel table that show one of the quantities of one of the wheels."""
        sources = {self.layout.at(name, wheel) for wheel in wheels for name in quantities}
        column = self._channels[:, kernel.C_SOURCE].tolist()
        return [row for row, source in enumerate(column) if int(source) in sources]

    def offset_channels(self, rows: Iterable[int], counts: Iterable[float]) -> None:
        """Channels are off by so many counts more."""
        for row, count in zip(rows, counts, strict=True):
            self._channels[row, kernel.C_OFFSET] += count

    def _run(self, steps: int, first: int, last: int) -> None:
        kernel.advance(*self._arrays, steps, first, last)
        self.time_s += steps * self._step_s

    def check_gone(self) -> None:
        """A robot far outside the pipe has come to rest; nothing moves any more."""
        arcs = self.arcs()
        outside = max(-max(arcs), min(arcs) - self.pipe.length_m)
        if self.gone or outside < _GONE_M:
            return
        self.gone = True
        self.state.velocity[:] = 0.0
        # It lies on the floor: the accelerometer feels its weight, whichever way it lies.
        for axis, value in (("acc_x", 0.0), ("acc_y", 0.0), ("acc_z", GRAVITY_M_S2)):
            self.out[self.layout.at(axis)] = value


def _constants(machine: Machine, pipe: Pipe, dt: float) -> Floats:
    world = np.zeros(kernel.WORLD_ENTRIES)
    chain = machine.chain
    world[kernel.DT] = dt
    world[kernel.ITERATIONS] = _ITERATIONS
    world[kernel.RADIUS] = chain.wheel_radius_m
    world[kernel.HALF_THICKNESS] = chain.half_thickness_m
    world[kernel.CONTACT_COMPLIANCE] = _CONTACT_COMPLIANCE_M_N
    world[kernel.ANCHOR_MAX] = _ANCHOR_M
    world[kernel.DEPTH] = pipe.diameter_m / 2.0
    world[kernel.BLOCK_NODE] = -1
    world[kernel.ROLL_LINK] = chain.roll_link
    world[kernel.ROLL_RATE] = chain.roll_rate_rad_s
    world[kernel.ROLL_STALL] = chain.roll_stall_nm
    world[kernel.MAG_X : kernel.MAG_Z + 1] = _FIELD_UT
    return world


def _place(state: ChainState, machine: Machine, pipe: Pipe, pose: StartPose) -> None:
    """The robot stands in its start pose.

    Raises:
        UsageError: It does not fit there; says why.
    """
    chain = machine.chain
    held = {wheel: duty for wheel, duty in sorted(pose.duties.items()) if duty != 0.0}
    height = pipe.diameter_m - 2.0 * chain.wheel_radius_m if held else 0.0
    if any(height >= link.length_m for link in chain.links):
        raise UsageError("the robot cannot be clamped in so wide a pipe")
    # Joints alternate: that of an odd wheel with a negative duty has its V open to side B. The
    # strongest duty is that of a clamp; a part that bends is pushed with less, to either side.
    side = 1.0
    if held:
        strongest = max(held, key=lambda wheel: abs(held[wheel]))
        side = math.copysign(1.0, -held[strongest]) * (1.0 if strongest % 2 else -1.0)
    arc = pose.arc_m
    leg = pipe.piece_at(arc)
    tilts = []
    for i in range(chain.nodes):
        state.position[i] = pipe.point(arc, side * height / 2.0)
        if i == chain.nodes - 1:
            break
        length = chain.links[i].length_m
        tilts.append(side * math.asin(height / length))
        arc -= span_m(length, height)
        side = -side
    last_leg = pipe.piece_at(arc)
    if arc < 0.0 or pose.arc_m > pipe.length_m or last_leg is not leg:
        raise UsageError(
            f"the robot, {pose.arc_m - arc:.2f} m long there, does not fit between the bends and"
            f" ends of the pipe with its first wheel at {pose.arc_m:.2f} m"
        )
    for i in range(1, chain.nodes - 1):
        # Headings are against the leg's direction: a link to side A ahead of one to side B.
        state.bend[i] = tilts[i] - tilts[i - 1]
        joint = chain.joints.get(i)
        torque = pose.duties.get(i, 0.0) * joint.stall_nm if joint else 0.0
        stiffness = joint.stiffness_nm_rad if joint else 1.0
        state.motor[i] = state.bend[i] + torque / stiffness
    state.roll[1] = state.roll[2] = pose.roll_rad
