"""The roll of a robot in MuJoCo, whose chain moves in a plane or in space."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, copysign, cos, inf, sin

import mujoco
import numpy as np

from pirate_sm.core.geometry import Route, Vector
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mujoco.model_text import LINK, ROLL, ROLL_REAR, WHEEL, X_DRAG, Y_DRAG
from pirate_sm.simulation.physics import ChainBody, QuantityLayout, StartPose

# --- in a plane ----------------------------------------------------------------------------------


# A part that lies in the pipe presses with up to its weight; one that was clamped and is relaxed
# presses with at least 4 weights.
_LYING_WEIGHTS = 2.0
# The floor takes at most what stops a wheel's share of the mass within this time, as in the
# kinematic simulator: below 10 mm/s its friction falls with the speed.
_STOPS_IN_S = 0.002
# Far less than a wheel moves in a cycle: at rest both motors share the floor's force.
_AT_REST_M = 1e-9
_SIDES = (1, 2)


class RollInPlane:
    """Turns the roll joint, and gives the parts the gravity and the floor of their roll.

    The same rules as the kinematic simulator's: a part that is wedged does not turn, one that only
    lies there turns against the friction of its wheels; a wheel that presses no wall lies on the
    floor and drags there by its weight.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        route: Where it is.
        pose: How it begins.
        quantities: Where the quantities are written.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: ChainBody,
        route: Route,
        pose: StartPose,
        quantities: Floats,
    ) -> None:
        self._model, self._data, self._chain, self._route = model, data, chain, route
        n, layout = chain.nodes, QuantityLayout(chain.nodes)
        self._arcs = quantities[layout.block("arc")]
        self._press = quantities[layout.block("press")]
        self._quantities, self._roll = quantities, layout.at("roll")
        self._current = layout.at("roll_current")
        self._parts = np.array([1 if i <= chain.roll_link else 2 for i in range(n)])
        self._masses = np.array([_node_mass(chain, i) for i in range(n)])
        self._radius_m = route.pieces[0].diameter_m / 2
        self._bodies = np.array([model.body(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._sites = np.array([model.site(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._before: Floats = np.array(pose.places)
        self._drags = np.array(
            [[model.actuator(f"{name}{i}").id for name in (X_DRAG, Y_DRAG)] for i in range(n)],
            dtype=np.intp,
        )
        model.actuator_biasprm[self._drags, 2] = -self._masses[:, None] / _STOPS_IN_S
        self._rolls = list(pose.rolls_rad or (0.0, pose.roll_rad, pose.roll_rad))
        self._target_rad = 0.0

    def turn_to(self, angle_rad: float) -> None:
        """Give the roll joint a new target."""
        self._target_rad = angle_rad

    def rolls(self) -> Sequence[float]:
        """Return the angle of the joint, then the roll of the part ahead and behind."""
        return tuple(self._rolls)

    def prepare(self, gravity: Vector, static: Floats, kinetic: Floats, cycle_s: float) -> None:
        """Let the joint turn for a cycle, and give each wheel its gravity and its floor.

        Args:
            gravity: Of the world, m/s².
            static: Friction coefficient of each wheel.
            kinetic: The same of one that slides.
            cycle_s: Length of the cycle.
        """
        g = sum(each * each for each in gravity) ** 0.5
        lies = (False, self._lies(1, g), self._lies(2, g))
        self._turn(lies, static, cycle_s)
        _, front, rear = self._rolls
        self._data.xfrc_applied[:] = 0.0
        if front == rear == 0.0:
            floor = np.full(len(self._masses), abs(gravity[2]))
        else:
            # The joints of the part that holds bear the weight of the other, in their own plane.
            if front != rear and lies[1] != lies[2]:
                front, rear = (rear, rear) if lies[1] else (front, front)
            felt = [self.gravity_at(i, gravity, (front, rear)) for i in range(len(self._masses))]
            floor = np.array([abs(each[2]) for each in felt])
            more = (np.array(felt) - gravity) * [1.0, 1.0, 0.0]
            self._data.xfrc_applied[self._bodies, :3] = self._masses[:, None] * more
        most = np.where(self._press == 0.0, kinetic * floor * self._masses, 0.0)
        drag = most[:, None] * self._directions()
        model = self._model
        model.actuator_forcerange[self._drags, 0] = -drag
        model.actuator_forcerange[self._drags, 1] = drag

    def _directions(self) -> Floats:
        """Return the way in which each wheel moves, along its link and across: unit vectors.

        The motors along and across share the floor's force by it, so that the floor drags against
        the motion, and by the same force whichever way a wheel moves.
        """
        data = self._data
        places = data.xpos[self._bodies].copy()
        moved, self._before = places - self._before, places
        axes = data.site_xmat[self._sites].reshape(-1, 3, 3)
        own = np.abs(np.einsum("ijk,ij->ik", axes, moved)[:, :2]) + _AT_REST_M
        shares: Floats = own / np.linalg.norm(own, axis=1, keepdims=True)
        return shares

    def gravity_at(self, wheel: int, gravity: Vector, rolls: Sequence[float]) -> Vector:
        """Return what a wheel's part feels of gravity in its own plane and square to it, m/s²."""
        roll = rolls[0] if self._parts[wheel] == 1 else rolls[1]
        if roll == 0.0:
            return gravity
        ahead = self._route.piece_at(float(self._arcs[wheel])).frame.ahead
        along = gravity[0] * ahead[0] + gravity[1] * ahead[1]
        aside = gravity[1] * ahead[0] - gravity[0] * ahead[1]
        across = aside * cos(roll) - gravity[2] * sin(roll)
        return (
            along * ahead[0] - across * ahead[1],
            along * ahead[1] + across * ahead[0],
            aside * sin(roll) + gravity[2] * cos(roll),
        )

    def _lies(self, part: int, g: float) -> bool:
        """Return whether a part lies in the pipe, not wedged."""
        mine = self._parts == part
        press = float(self._press[mine].sum())
        return press <= _LYING_WEIGHTS * float(self._masses[mine].sum()) * g

    def _turn(self, lies: Sequence[bool], static: Floats, cycle_s: float) -> None:
        """Turn the joint towards its target as far as one of the parts can turn."""
        out, chain = self._quantities, self._chain
        out[self._roll], out[self._current] = self._rolls[0], 0.0
        wanted = self._target_rad - self._rolls[0]
        if wanted == 0.0:
            return
        turning, friction = 0, inf
        for part in _SIDES:
            mine = self._parts == part
            torque = float((static * self._press)[mine].sum()) * self._radius_m
            if lies[part] and torque < friction:
                turning, friction = part, torque
        load = friction / chain.roll_stall_nm
        if turning == 0 or load >= 1.0:
            out[self._current] = 1.0
            return
        reach = chain.roll_rate_rad_s * (1.0 - load) * cycle_s
        turn = copysign(min(abs(wanted), reach), wanted)
        self._rolls[0] += turn
        self._rolls[turning] += turn if turning == 1 else -turn
        out[self._roll], out[self._current] = self._rolls[0], load


def _node_mass(chain: ChainBody, wheel: int) -> float:
    """Return the mass of a wheel and of the halves of the links beside it."""
    links = [chain.links[m] for m in (wheel - 1, wheel) if 0 <= m < len(chain.links)]
    return chain.wheels[wheel].mass_kg + sum(0.5 * link.mass_kg for link in links)


# --- in space ------------------------------------------------------------------------------------


_AHEAD_RAD = 0.05
"""How far the controller's angle may run ahead of a joint that does not turn."""


class RollInSpace:
    """Turns the roll joint at its motor's speed, and reads how the two parts lie.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        route: The straight pipe that it is in.
        quantities: Where the quantities are written.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: ChainBody,
        route: Route,
        quantities: Floats,
    ) -> None:
        self._data, self._chain, self._quantities = data, chain, quantities
        layout = QuantityLayout(chain.nodes)
        self._roll, self._current = layout.at("roll"), layout.at("roll_current")
        frame = route.pieces[0].frame
        self._side, self._normal = np.array(frame.side), np.array(frame.normal)
        self._ahead = model.body(f"{LINK}0").id
        self._rear = model.body(f"{LINK}{len(chain.links) - 1}").id
        self._joint = self._motor = -1
        if chain.roll_link >= 0:
            self._joint = int(model.joint(ROLL).qposadr[0])
            self._motor = model.actuator(ROLL).id
            self._ahead = model.body(f"{LINK}{chain.roll_link}").id
            self._rear = model.body(ROLL_REAR).id
        self._target_rad = 0.0

    def turn_to(self, angle_rad: float) -> None:
        """Give the roll joint a new target."""
        self._target_rad = angle_rad

    def rolls(self) -> Sequence[float]:
        """Return the angle of the joint, then the roll of the part ahead and behind."""
        angle = float(self._data.qpos[self._joint]) if self._joint >= 0 else 0.0
        return (angle, self._roll_of(self._ahead), self._roll_of(self._rear))

    def prepare(self, cycle_s: float) -> None:
        """Let the controller's angle go towards the target for a cycle."""
        if self._joint < 0:
            return
        data, reach = self._data, self._chain.roll_rate_rad_s * cycle_s
        angle, now = float(data.qpos[self._joint]), float(data.ctrl[self._motor])
        aim = now + min(max(self._target_rad - now, -reach), reach)
        data.ctrl[self._motor] = min(max(aim, angle - _AHEAD_RAD), angle + _AHEAD_RAD)
        self._quantities[self._roll] = angle
        force = abs(float(data.actuator_force[self._motor]))
        self._quantities[self._current] = force / self._chain.roll_stall_nm

    def _roll_of(self, body: int) -> float:
        """Return how far the plane of a body is rolled about the pipe's axis, rad."""
        axle = self._data.xmat[body, 2::3]
        return atan2(float(axle @ self._side), float(axle @ self._normal))
