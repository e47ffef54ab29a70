"""The forces that MuJoCo's chain is given: of its motors, and between wheels and walls."""

from __future__ import annotations

from math import hypot

import mujoco
import numpy as np

from pirate_sm.core.geometry import Vector, crossed, dot
from pirate_sm.core.models import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mujoco.model_text import BEND, LINK, OBSTACLE, WHEEL
from pirate_sm.simulation.mujoco.tyre_edges import TyreEdges
from pirate_sm.simulation.physics import ChainBody, QuantityLayout, StartPose

# --- motors --------------------------------------------------------------------------------------


_WHEEL_FILTER = 0.5  # of x_velocity, a mean of angle differences (thesis B-11)


class Motors:
    """Turns duties into what MuJoCo's actuators do for a cycle, and reads what came of it.

    A worm turns its side of the spring at no-load speed × (duty - torque / stall torque) and is
    never driven back; the spring is the actuator. A wheel's motor gives stall torque × duty less
    what its speed costs; at duty 0, or with a failed motor, dry friction resists. So does the
    tyre, by its rolling resistance times the normal force of the cycle before: friction of the
    axle, which never drives.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        pose: How it begins.
        quantities: Where the quantities are written.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: ChainBody,
        pose: StartPose,
        quantities: Floats,
    ) -> None:
        self._model, self._data = model, data
        n, layout = chain.nodes, QuantityLayout(chain.nodes)
        out = {
            name: quantities[layout.block(name)]
            for name in (
                "bend", "bend_torque", "bend_current", "wheel", "turned", "drive", "grip", "press"
            )
        }  # fmt: skip
        self._out = out
        self._at = np.array(sorted(chain.joints), dtype=np.intp)
        springs = [chain.joints[i] for i in self._at]
        self._stiffness = np.array([each.stiffness_nm_rad for each in springs])
        self._rate = np.array([each.rate_rad_s for each in springs])
        self._stall = np.array([each.stall_nm for each in springs])
        joints = [model.joint(f"{BEND}{i}") for i in self._at]
        self._bend = np.array([joint.qposadr[0] for joint in joints], dtype=np.intp)
        self._bend_dof = np.array([joint.dofadr[0] for joint in joints], dtype=np.intp)
        worms = [model.actuator(f"{BEND}{i}") for i in self._at]
        self._worm = np.array([each.id for each in worms], dtype=np.intp)
        self._wound = np.array([each.actadr[0] for each in worms], dtype=np.intp)
        wheels = [model.joint(f"{WHEEL}{i}") for i in range(n)]
        self._wheel = np.array([joint.qposadr[0] for joint in wheels], dtype=np.intp)
        self._wheel_dof = np.array([joint.dofadr[0] for joint in wheels], dtype=np.intp)
        self._motor = np.array([model.actuator(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._wheel_stall = np.array([each.stall_nm for each in chain.wheels])
        self._wheel_rate = np.array([each.rate_rad_s for each in chain.wheels])
        self._hold = np.array([each.hold_nm for each in chain.wheels])
        self._read = np.zeros(n)
        self._radius_m = chain.wheel_radius_m
        self._resistance_m = chain.rolling_resistance * chain.wheel_radius_m
        out["bend"][:] = pose.bends_rad
        data.qpos[self._bend] = np.array(pose.bends_rad)[self._at]
        data.act[self._wound] = np.array(pose.motors_rad)[self._at]

    def drive(self, duties: Floats) -> None:
        """Let the motors do for the next cycle what these duties ask for."""
        data, model, out = self._data, self._model, self._out
        n = len(self._motor)
        duty = duties[self._at]
        share = duty - self._torques() / self._stall
        share = np.clip(share, np.minimum(duty, 0.0), np.maximum(duty, 0.0))
        data.ctrl[self._worm] = self._rate * share
        out["bend_current"][self._at] = np.abs(duty - share)
        duty = duties[n:]
        working = self._wheel_rate > 0.0
        driven = working & (duty != 0.0)
        data.ctrl[self._motor] = np.where(driven, self._wheel_stall * duty, 0.0)
        slope = self._wheel_stall / np.where(working, self._wheel_rate, 1.0)
        model.dof_damping[self._wheel_dof] = np.where(driven, slope, 0.0)
        held = np.where(driven, 0.0, self._hold)
        model.dof_frictionloss[self._wheel_dof] = held + self._resistance_m * out["press"]

    def read(self, duties: Floats) -> None:
        """Write the quantities of the motors after a cycle; `grip` must have been written."""
        data, out = self._data, self._out
        out["bend"][self._at] = data.qpos[self._bend]
        out["bend_torque"][self._at] = self._torques()
        wheel = data.qpos[self._wheel]
        out["wheel"][:] = wheel
        out["turned"][:] += _WHEEL_FILTER * (wheel - self._read - out["turned"])
        self._read = wheel.copy()
        ctrl = data.ctrl[self._motor]
        slope = self._model.dof_damping[self._wheel_dof]
        driven = np.abs(ctrl - slope * data.qvel[self._wheel_dof])
        held = np.minimum(np.abs(out["grip"]) * self._radius_m, self._hold)
        out["drive"][:] = np.where(ctrl != 0.0, driven, held)

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        """Stop driving a wheel; from now on it drags with this torque."""
        self._wheel_rate[wheel] = 0.0
        self._hold[wheel] = drag_nm

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        """Set the dry friction of the joint at a wheel."""
        at = self._bend_dof[self._at == wheel]
        self._model.dof_frictionloss[at] = friction_nm

    def _torques(self) -> Floats:
        """Return the torques of the springs."""
        data = self._data
        found: Floats = self._stiffness * (data.act[self._wound] - data.qpos[self._bend])
        return found


# --- wheel contacts ------------------------------------------------------------------------------


_FULL_SLIP = 1.5
"""From this multiple of the threshold speed on the kinetic coefficient holds; the thesis's fig. 4-3
gives no number."""

_REACHED = 0.99
"""Share of the friction from which on it is exhausted."""


class WheelContacts:
    """Reads the forces of the walls on the wheels and gives each wheel the friction of its slip.

    The cone's coefficient is static up to the threshold of the slip speed and falls to the kinetic
    one at 1.5 times that speed (thesis fig. 4-3); within the cone, MuJoCo lets a wheel stick.
    Against spinning on the spot, which it can do in space alone, that of the tyre's contact holds.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        friction: Of every wheel.
        quantities: Where the quantities are written.
        edges: Turn the axles of wheels that lean, if any can.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: ChainBody,
        friction: Friction,
        quantities: Floats,
        edges: TyreEdges | None,
    ) -> None:
        self._data = data
        n, layout = chain.nodes, QuantityLayout(chain.nodes)
        self._press = quantities[layout.block("press")]
        self._grip = quantities[layout.block("grip")]
        self._bodies = np.array([model.body(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._geoms = np.array([model.geom(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._wheel_of = {int(geom): i for i, geom in enumerate(self._geoms)}
        self._root = model.body(f"{LINK}0").id
        self._obstacle = int(model.body(OBSTACLE).geomadr[0])
        self._radius_m = chain.wheel_radius_m
        self.static, self.kinetic = np.zeros(n), np.zeros(n)
        self._threshold_m_s = friction.threshold
        for wheel in range(n):
            self.let_grip(wheel, friction.static, friction.kinetic)
        # A wheel that slides with little force hops: between two hops it slides on.
        self._slips = np.zeros(n)
        self._spin_radius_m = chain.spin_radius_m
        self._touches = model.pair_friction.reshape(n, -1, 5)
        self._edges = edges
        self._set_friction()

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""
        self.static[wheel], self.kinetic[wheel] = static, kinetic

    def read(self) -> None:
        """Write press and grip after a cycle, and set each wheel's friction for the next one."""
        n = len(self.static)
        press, grip, strongest = [0.0] * n, [0.0] * n, [0.0] * n
        normals = [(0.0, 0.0, 0.0)] * n
        contact, forces = self._data.contact, self._data.efc_force
        axles = self._data.xmat[self._bodies, 2::3].tolist()
        for (one, other), address, frame in zip(
            contact.geom.tolist(), contact.efc_address.tolist(), contact.frame.tolist(), strict=True
        ):
            # A contact's frame begins with the normal from the first body to the second.
            second = other in self._wheel_of
            wheel = self._wheel_of.get(other if second else one)
            if wheel is None or address < 0 or self._obstacle in (one, other):
                continue
            push, first_n, second_n = forces[address : address + 3].tolist()
            sign = 1.0 if second else -1.0
            normal = (sign * frame[0], sign * frame[1], sign * frame[2])
            tangent = crossed(axles[wheel], normal)
            along = first_n * dot(frame[3:6], tangent) + second_n * dot(frame[6:], tangent)
            press[wheel] += push
            grip[wheel] += sign * along
            if push > strongest[wheel]:
                strongest[wheel], normals[wheel] = push, normal
                # A wheel that sticks creeps a little; it slips where its friction is exhausted.
                slips = hypot(first_n, second_n) >= _REACHED * self._friction[wheel] * push
                self._slips[wheel] = self._slip(wheel, normal) if slips else 0.0
        self._press[:] = press
        self._grip[:] = grip
        self._set_friction()
        if self._edges is not None:
            self._edges.turn_axles(normals)

    def _set_friction(self) -> None:
        beyond = self._slips / self._threshold_m_s - 1.0
        share = np.clip(beyond / (_FULL_SLIP - 1.0), 0.0, 1.0)
        friction = self.static + share * (self.kinetic - self.static)
        self._friction: Floats = friction
        self._touches[:, :, :2] = friction[:, None, None]
        self._touches[:, :, 2] = friction[:, None] * self._spin_radius_m

    def _slip(self, wheel: int, normal: Vector) -> float:
        """Return how fast the wheel's surface moves along the wall that it touches, m/s."""
        data, body, r = self._data, self._bodies[wheel], self._radius_m
        x, y, z = data.subtree_com[self._root].tolist()
        a, b, c, u, v, w = data.cvel[body].tolist()
        px, py, pz = data.xpos[body].tolist()
        mx, my, mz = crossed((a, b, c), (px - x, py - y, pz - z))
        sx, sy, sz = crossed((a, b, c), normal)
        surface = (u + mx - r * sx, v + my - r * sy, w + mz - r * sz)
        off = dot(surface, normal)
        return float(max(dot(surface, surface) - off * off, 0.0) ** 0.5)
