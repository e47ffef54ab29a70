"""The physics of a chain in a pipe by MuJoCo: in the pipe's plane, or in space if it is round."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, sin

import mujoco
import numpy as np

from pirate_sm.core.errors import BackendError
from pirate_sm.core.geometry import GRAVITY_M_S2, Route, Vector
from pirate_sm.core.models import Friction
from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.mujoco.forces import Motors, WheelContacts
from pirate_sm.simulation.mujoco.model_text import LINK, OBSTACLE, WHEEL, model_text
from pirate_sm.simulation.mujoco.roll import RollInPlane, RollInSpace
from pirate_sm.simulation.mujoco.tyre_edges import TyreEdges
from pirate_sm.simulation.physics import ChainBody, QuantityLayout, StartPose
from pirate_sm.simulation.start_pose import lying

# --- the inertial unit ---------------------------------------------------------------------------


# Along the first leg and against its normal, uT: the kinematic simulator's, in the same axes.
_FIELD_UT = (20.0, 0.0, -44.0)


class InertialUnit:
    """Writes specific force and magnetic field along forward, side B and up.

    Args:
        model: MuJoCo's model of the robot.
        data: Its state.
        chain: The robot.
        quantities: Where the quantities are written.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, chain: ChainBody, quantities: Floats
    ) -> None:
        first = QuantityLayout(chain.nodes).at("acc_x")
        self._out = quantities[first : first + 6]
        link = min(max(chain.roll_link, 0), len(chain.links) - 1)
        self.wheel = link
        self._data = data
        self._link = model.body(f"{LINK}{link}").id
        self._place = model.body(f"{WHEEL}{link}").id
        self._before: Floats | None = None
        self._chain = chain
        self._velocity = np.zeros(3)

    def read(self, gravity: Vector, roll_rad: float, cycle_s: float) -> None:
        """Write what it feels after a cycle; the specific force is averaged.

        Args:
            gravity: Where the unit is, in its own plane and square to it, m/s².
            roll_rad: How far it is rolled beside what its link's frame shows.
            cycle_s: Length of the cycle.
        """
        place = self._data.xpos[self._place].copy()
        share = 1.0 if self._before is None else self._chain.felt_share(cycle_s)
        before = place if self._before is None else self._before
        velocity = (place - before) / cycle_s
        acceleration = (velocity - self._velocity) / cycle_s
        self._before, self._velocity = place, velocity
        axes = self._data.xmat[self._link].reshape(3, 3).T * [[1.0], [-1.0], [-1.0]]
        self._out[:3] += share * (axes @ (acceleration - gravity) - self._out[:3])
        field = axes @ _FIELD_UT
        cos, sin = np.cos(roll_rad), np.sin(roll_rad)
        self._out[3] = field[0]
        self._out[4] = field[1] * cos - field[2] * sin
        self._out[5] = field[1] * sin + field[2] * cos


# --- the world -----------------------------------------------------------------------------------


STEP_S = 0.002
_FAR_M = 1000.0
_UNSTABLE = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)


class MujocoWorld:
    """A chain in a pipe; a :class:`~pirate_sm.simulation.physics.Physics`.

    Args:
        chain: What moves.
        route: Where it is: in a plane, or a straight round pipe.
        friction: Between wheels and walls.
        pose: How it stands.
        cycle_s: How long a cycle lasts.

    Attributes:
        model: MuJoCo's model.
        data: MuJoCo's state.
        duties: Duties in force, of joints, then of wheels.
        quantities: Quantities after the last cycle.

    Raises:
        UsageError: The pipe cannot be built.
    """

    def __init__(
        self, chain: ChainBody, route: Route, friction: Friction, pose: StartPose, cycle_s: float
    ) -> None:
        n, layout = chain.nodes, QuantityLayout(chain.nodes)
        self.duties: Floats = np.zeros(2 * n)
        self.quantities: Floats = np.zeros(layout.size)
        self._route, self._cycle_s = route, cycle_s
        self._steps = max(1, round(cycle_s / STEP_S))
        space = route.pieces[0].section == "round"
        text = model_text(chain, route, pose, cycle_s / self._steps, space=space)
        self.model = mujoco.MjModel.from_xml_string(text)
        self.data = mujoco.MjData(self.model)
        self._gravity: Vector = (0.0, 0.0, 0.0)
        self.turn_gravity(route.up)
        model, data, out = self.model, self.data, self.quantities
        self._arc = out[layout.block("arc")]
        self._wheels = np.array([model.body(f"{WHEEL}{i}").id for i in range(n)], dtype=np.intp)
        self._motors = Motors(model, data, chain, pose, out)
        edges = TyreEdges(model, data, chain) if space else None
        self._contacts = WheelContacts(model, data, chain, friction, out, edges)
        self._unit = InertialUnit(model, data, chain, out)
        self._roll: RollInPlane | RollInSpace
        if space:
            self._roll = RollInSpace(model, data, chain, route, out)
            places = lying(pose, chain, route)
            data.qpos[:7] = (*places[0], *_standing(pose, places))
        else:
            self._roll = RollInPlane(model, data, chain, route, pose, out)
            data.qpos[:3] = (*pose.places[0][:2], _heading(pose.places))
        self._obstacle = int(model.body(OBSTACLE).mocapid[0])
        mujoco.mj_forward(model, data)
        self._read()

    def turn_gravity(self, up: Vector) -> None:
        """Let gravity pull against this unit vector from now on."""
        x, y, z = up
        self._gravity = (-GRAVITY_M_S2 * x, -GRAVITY_M_S2 * y, -GRAVITY_M_S2 * z)
        self.model.opt.gravity[:] = self._gravity

    def let_grip(self, wheel: int, static: float, kinetic: float) -> None:
        """Give a wheel these friction coefficients."""
        self._contacts.let_grip(wheel, static, kinetic)

    def turn_roll_to(self, angle_rad: float) -> None:
        """Give the roll joint a new target."""
        self._roll.turn_to(angle_rad)

    def advance(self) -> None:
        """Let one cycle pass.

        Raises:
            BackendError: The world has become unstable.
        """
        self._motors.drive(self.duties)
        if isinstance(self._roll, RollInPlane):
            contacts = self._contacts
            self._roll.prepare(self._gravity, contacts.static, contacts.kinetic, self._cycle_s)
        else:
            self._roll.prepare(self._cycle_s)
        mujoco.mj_step(self.model, self.data, self._steps)
        if any(self.data.warning[each].number for each in _UNSTABLE):
            raise BackendError("MuJoCo's world has become unstable: numbers beyond all bounds")
        self._read()

    def places(self) -> Sequence[Vector]:
        """Return where the middle of each wheel is in the drawing of the pipe, m."""
        return [(x, y, z) for x, y, z in self.data.xpos[self._wheels].tolist()]

    def rolls(self) -> Sequence[float]:
        """Return the angle of the roll joint, then the roll of the part ahead and behind, rad."""
        return self._roll.rolls()

    def block(self, wheel: int, arc_m: float, ahead: bool) -> None:
        """Put an obstacle in the way of one wheel; `ahead`: the wheel is before it."""
        frame = self._route.frame_at(arc_m)
        turn = atan2(frame.ahead[1], frame.ahead[0]) + (0.0 if ahead else np.pi)
        self.data.mocap_pos[self._obstacle] = frame.origin
        self.data.mocap_quat[self._obstacle] = (cos(turn / 2), 0.0, 0.0, sin(turn / 2))

    def unblock(self) -> None:
        """Take the obstacle away."""
        self.data.mocap_pos[self._obstacle] = (_FAR_M, _FAR_M, 0.0)

    def disable_wheel(self, wheel: int, drag_nm: float) -> None:
        """Stop driving a wheel; from now on it drags with this torque."""
        self._motors.disable_wheel(wheel, drag_nm)

    def stiffen_joint(self, wheel: int, friction_nm: float) -> None:
        """Set the dry friction of the joint at a wheel."""
        self._motors.stiffen_joint(wheel, friction_nm)

    def _read(self) -> None:
        """Fill the arrays of all quantities from the physics."""
        self._arc[:] = [self._route.arc_of(place) for place in self.places()]
        self._contacts.read()
        self._motors.read(self.duties)
        gravity, roll = self._gravity, 0.0
        if isinstance(self._roll, RollInPlane):
            _, *rolls = self._roll.rolls()
            gravity, roll = self._roll.gravity_at(self._unit.wheel, gravity, rolls), rolls[0]
        self._unit.read(gravity, roll, self._cycle_s)


def _heading(places: Sequence[Vector]) -> float:
    """Return the direction of the first link in the drawing, rad."""
    (x0, y0, _), (x1, y1, _) = places[:2]
    return atan2(y0 - y1, x0 - x1)


def _standing(pose: StartPose, places: Sequence[Vector]) -> tuple[float, float, float, float]:
    """Return how the first link of a robot in space is turned, as a quaternion."""
    heading, roll = _heading(pose.places) / 2, -pose.roll_rad / 2
    ch, sh, cr, sr = cos(heading), sin(heading), cos(roll), sin(roll)
    return cr * ch, sr * ch, -sr * sh, cr * sh
