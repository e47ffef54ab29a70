"""The motors of a chain in MuJoCo: worms behind springs, and geared wheels."""

from __future__ import annotations

import mujoco
import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.mujoco.names import BEND, WHEEL
from pirate_sm.simulation.physics import QuantityLayout, StartPose

_WHEEL_FILTER = 0.5  # of x_velocity, a mean of angle differences (thesis B-11)


class Motors:
    """Turns duties into what MuJoCo's actuators do for a cycle, and reads what came of it.

    A worm turns its side of the spring at no-load speed × (duty - torque / stall torque) and is
    never driven back; the spring is the actuator. A wheel's motor gives stall torque × duty less
    what its speed costs; at duty 0, or with a failed motor, dry friction resists.

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
                "bend", "bend_torque", "bend_current", "wheel", "turned", "drive", "grip"
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
        model.dof_frictionloss[self._wheel_dof] = np.where(driven, 0.0, self._hold)

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
        """Let a wheel turn by its motor no more, and drag with this torque."""
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
