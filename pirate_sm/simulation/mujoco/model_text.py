"""The text of MuJoCo's model (MJCF) of a robot in a pipe, with the settings that make it true."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, tostring

from pirate_sm.core.geometry import Route
from pirate_sm.simulation.mechanics import ChainBody
from pirate_sm.simulation.mujoco.names import numbers
from pirate_sm.simulation.mujoco.pipe_model import add_pipe
from pirate_sm.simulation.mujoco.robot_model import add_robot
from pirate_sm.simulation.physics import StartPose

# About the 1e5 N/m of the kinematic simulator; with 1000 N/m a clamped V toggles through the wall.
# At 0.004, two steps and the least that is stable, a wheel that slides with 1 N hops.
_CONTACT = {"solref": "0.008 1", "solimp": "0.95 0.99 0.0005"}
# In space contacts are as stiff as is stable: there a wheel has no margin, and on softer plates it
# would roll on a radius that is 0.4 % too small.
_CONTACT_IN_SPACE = {**_CONTACT, "solref": "0.004 1"}
# With MuJoCo's own numbers a joint goes 5 deg beyond its stop at 0.7 Nm, and brakes creep.
_STIFF_JOINT = {
    "solreflimit": "0.004 1",
    "solimplimit": "0.99 0.999 0.0002",
    "solreffriction": "0.004 1",
    "solimpfriction": "0.99 0.999 0.0002",
}


def model_text(
    chain: ChainBody, route: Route, pose: StartPose, step_s: float, *, space: bool
) -> str:
    """Return the model of a chain that begins in a pose, in a route's pipe.

    Args:
        chain: The robot.
        route: The pipe.
        pose: How the robot stands.
        step_s: Time step.
        space: Whether it moves in space; else in the plane of the pipe.

    Raises:
        UsageError: The pipe cannot be built.
    """
    model = Element("mujoco", model="robot in a pipe")
    SubElement(model, "compiler", angle="radian", autolimits="true")
    option = SubElement(
        model, "option", timestep=numbers(step_s), integrator="implicitfast", solver="Newton",
        cone="elliptic", impratio="10",
    )  # fmt: skip
    # A world that has become unstable must not begin anew by itself.
    SubElement(option, "flag", autoreset="disable")
    default = SubElement(model, "default")
    SubElement(
        default,
        "geom",
        {"condim": "4", **_CONTACT_IN_SPACE} if space else {"condim": "3", **_CONTACT},
    )
    SubElement(default, "joint", _STIFF_JOINT)
    world = SubElement(model, "worldbody")
    actuators = Element("actuator")
    add_pipe(world, route, space=space)
    add_robot(world, actuators, chain, pose, space=space)
    model.append(actuators)
    return tostring(model, encoding="unicode")
