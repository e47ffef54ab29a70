"""The text of MuJoCo's model (MJCF) of a robot in a pipe, with the settings that make it true."""

from __future__ import annotations

import math
from math import atan2, cos, dist, pi, sin, tan
from xml.etree.ElementTree import Element, SubElement, tostring

from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import Piece, Route, flat, walls
from pirate_sm.simulation.physics import ChainBody, LinkBody, StartPose

# --- names of parts ------------------------------------------------------------------------------


LINK, WHEEL, BEND = "link_", "wheel_", "bend_"
"""A link by its number; a wheel, its motor and its site; the joint at a wheel and its spring."""
ROLL, ROLL_REAR = "roll", "roll_rear"
X_DRAG, Y_DRAG = "x_drag_", "y_drag_"
"""The friction of a wheel that lies on the floor, along and across its link."""
OBSTACLE, WALL = "obstacle", "wall_"

WHEEL_BIT, LINK_BIT = "1", "2"
"""What touches what: links touch walls, wheels an obstacle; wheels and walls are pairs."""


def numbers(*values: float) -> str:
    """Return numbers as the model's text has them."""
    return " ".join(f"{value:.12g}" for value in values)


# --- the pipe ------------------------------------------------------------------------------------


PLATES = 48
"""Of a round pipe; between two of them it is 0.2 % wider than on their middles."""
# Thin enough that the end of a bar at an inner corner hardly stands out of the next bar.
_HALF_M = 0.003
_FAR_M = 1000.0
_WALL = {"contype": "0", "conaffinity": LINK_BIT, "rgba": "0.6 0.7 0.8 0.25"}


def add_pipe(world: Element, route: Route, *, space: bool) -> None:
    """Add the walls of a route, and an obstacle that is far away, to the bodies of a world.

    Raises:
        UsageError: The pipe is round and not straight.
    """
    if not space:
        _add_bars(world, route)
    elif len(route.pieces) > 1:
        raise UsageError(
            "the backend physics has no bends in a round pipe: use a straight one, or"
            " `section: bars` for its plane"
        )
    else:
        _add_plates(world, route.pieces[0])
    half = route.pieces[0].diameter_m / 2
    body = SubElement(world, "body", name=OBSTACLE, mocap="true", pos=numbers(_FAR_M, _FAR_M, 0))
    # Its face is the origin, and it lies ahead of it.
    SubElement(
        body, "geom", type="box", pos=numbers(half, 0, 0), size=numbers(half, half, half),
        priority="3", condim="1", contype="0", conaffinity=WHEEL_BIT, rgba="0.7 0.2 0.2 1",
    )  # fmt: skip


def _add_bars(world: Element, route: Route) -> None:
    """Add a bar for each wall; it begins and ends where the walls meet."""
    half_m = route.pieces[0].diameter_m / 2
    for side, corners in enumerate(walls(route)):
        outwards = 1.0 if side == 0 else -1.0
        for piece, (x0, y0), (x1, y1) in zip(route.pieces, corners[:-1], corners[1:], strict=True):
            ahead_x, ahead_y = flat(piece.frame.ahead)
            off = outwards * _HALF_M
            place = ((x0 + x1) / 2 - off * ahead_y, (y0 + y1) / 2 + off * ahead_x, 0.0)
            turn = atan2(ahead_y, ahead_x) / 2
            _add_box(
                world, place, (cos(turn), 0.0, 0.0, sin(turn)),
                (dist((x0, y0), (x1, y1)) / 2, _HALF_M, half_m),
            )  # fmt: skip


def _add_plates(world: Element, piece: Piece) -> None:
    """Add plates that touch the round wall of a straight pipe along their middles.

    A plane, which is faster than a box, stands for each: between planes the pipe has no end.
    """
    radius, half = piece.diameter_m / 2, piece.length_m / 2
    for number in range(PLATES):
        angle = 2 * pi * number / PLATES
        across, up = cos(angle), sin(angle)
        SubElement(
            world, "geom", _WALL, type="plane", pos=numbers(half, radius * across, radius * up),
            zaxis=numbers(0, -across, -up), size=numbers(half, radius * tan(pi / PLATES), half),
        )  # fmt: skip


def _add_box(
    world: Element,
    place: tuple[float, float, float],
    turn: tuple[float, float, float, float],
    size: tuple[float, float, float],
) -> None:
    SubElement(
        world, "geom", _WALL, type="box", pos=numbers(*place), quat=numbers(*turn),
        size=numbers(*size),
    )  # fmt: skip


# --- the robot -----------------------------------------------------------------------------------
# Frames: x of a link points ahead, y to side A, z is the axle of wheels and joints. The first
# wheel is the origin of the first link; each further link has its own origin in the wheel ahead of
# it.


GIVES_WAY_M = 1.5e-4
"""How much earlier a wheel's contact begins to press, in the plane: by what it gives way under a
clamp's usual 30 N, so that a clamped wheel rolls on its own radius. In space a wheel would press on
several plates of the wall at once and drive 10 % slower."""

WINDING_RAD = 0.6
"""The motor side of a spring may wind this far beyond the joint's own end stop."""
_ROLL_STIFFNESS_NM_RAD = 40.0
_ROLL_DAMPING_NMS_RAD = 0.4


def add_robot(
    world: Element, actuators: Element, chain: ChainBody, pose: StartPose, *, space: bool
) -> None:
    """Add the chain in its start pose to the bodies of a world and to its actuators.

    Args:
        world: The element that holds the bodies.
        actuators: The element that holds the motors.
        chain: The robot.
        pose: How it stands; only joints without a spring are built as they stand.
        space: Whether it moves in space, with its roll joint; else in the plane z = 0.
    """
    body = SubElement(world, "body", name=f"{LINK}0")
    if space:
        SubElement(body, "freejoint", name="root")
    else:
        for name, kind, axis in (("x", "slide", "1 0 0"), ("y", "slide", "0 1 0")):
            SubElement(body, "joint", name=name, type=kind, axis=axis)
        SubElement(body, "joint", name="heading", type="hinge", axis="0 0 1")
    last = len(chain.links) - 1
    for m, link in enumerate(chain.links):
        _add_wheel(body, actuators, chain, m, m, 0.0)
        rear_m = -link.length_m
        if space and m == chain.roll_link:
            body = _add_roll_joint(body, actuators, chain, link)
            rear_m = -link.length_m / 2
        else:
            _add_link(body, chain, link)
        _add_wheel(body, actuators, chain, m, m + 1, rear_m)
        if m < last:
            body = _add_next(body, actuators, chain, pose, m + 1, rear_m)
    for i in range(chain.nodes if not space else 0):
        for name, gear in ((X_DRAG, "1 0 0 0 0 0"), (Y_DRAG, "0 1 0 0 0 0")):
            site = f"{WHEEL}{i}"
            SubElement(
                actuators, "velocity", name=f"{name}{i}", site=site, gear=gear, kv="1",
                forcerange="-1 1",
            )  # fmt: skip


def _add_link(body: Element, chain: ChainBody, link: LinkBody) -> None:
    """Add mass and shape of a link: half its mass at each end (thesis 3-4)."""
    half, thick = link.length_m / 2, chain.half_thickness_m
    along = link.mass_kg * half**2
    _add_inertia(body, link.mass_kg, -half, (0.5 * link.mass_kg * thick**2, along, along))
    _add_shape(body, chain, (0.0, -link.length_m))


def _add_roll_joint(body: Element, actuators: Element, chain: ChainBody, link: LinkBody) -> Element:
    """Add a link with a roll joint in its middle; return the body of its rear half."""
    half, thick, mass = link.length_m / 2, chain.half_thickness_m, link.mass_kg / 2
    small = (0.5 * mass * thick**2,) * 3
    _add_inertia(body, mass, 0.0, small)
    _add_shape(body, chain, (0.0, -half))
    rear = SubElement(body, "body", name=ROLL_REAR, pos=numbers(-half, 0, 0))
    SubElement(rear, "joint", name=ROLL, axis="1 0 0", damping=numbers(_ROLL_DAMPING_NMS_RAD))
    _add_inertia(rear, mass, -half, small)
    _add_shape(rear, chain, (0.0, -half))
    most = chain.roll_stall_nm
    SubElement(
        actuators, "position", name=ROLL, joint=ROLL, kp=numbers(_ROLL_STIFFNESS_NM_RAD),
        forcerange=numbers(-most, most),
    )  # fmt: skip
    return rear


def _add_next(
    body: Element, actuators: Element, chain: ChainBody, pose: StartPose, wheel: int, along_m: float
) -> Element:
    """Add the body of the link behind a wheel, with the joint there, and return it."""
    joint = chain.joints.get(wheel)
    place = numbers(along_m, 0, 0)
    name = f"{LINK}{wheel}"
    if joint is None:
        turn = pose.bends_rad[wheel] / 2
        return SubElement(
            body, "body", name=name, pos=place, quat=numbers(math.cos(turn), 0, 0, math.sin(turn))
        )
    behind = SubElement(body, "body", name=name, pos=place)
    stop, most = joint.stop_rad, joint.stop_rad + WINDING_RAD
    SubElement(
        behind, "joint", name=f"{BEND}{wheel}", axis="0 0 1",
        range=numbers(-stop, stop), damping=numbers(joint.damping_nms_rad),
        frictionloss=numbers(joint.friction_nm),
    )  # fmt: skip
    SubElement(
        actuators, "intvelocity", name=f"{BEND}{wheel}", joint=f"{BEND}{wheel}",
        kp=numbers(joint.stiffness_nm_rad), actrange=numbers(-most, most),
    )  # fmt: skip
    return behind


def _add_wheel(
    body: Element,
    actuators: Element,
    chain: ChainBody,
    link: int,
    i: int,
    along_m: float,
) -> None:
    """Add a wheel to the body of the link that its motor sits on; on another link do nothing."""
    wheel = chain.wheels[i]
    if wheel.motor_link != link:
        return
    radius, place = chain.wheel_radius_m, numbers(along_m, 0, 0)
    SubElement(body, "site", name=f"{WHEEL}{i}", pos=place)
    turning = SubElement(body, "body", name=f"{WHEEL}{i}", pos=place)
    SubElement(
        turning, "joint", name=f"{WHEEL}{i}", axis="0 0 1",
        armature=numbers(wheel.rotor_inertia_kgm2),
    )  # fmt: skip
    axle = 0.5 * wheel.mass_kg * radius**2
    _add_inertia(turning, wheel.mass_kg, 0.0, (axle / 2, axle / 2, axle))
    SubElement(
        turning, "geom", name=f"{WHEEL}{i}", type="sphere", size=numbers(radius), priority="1",
        contype=WHEEL_BIT, conaffinity="0", rgba="0.2 0.2 0.2 1",
    )  # fmt: skip
    SubElement(actuators, "motor", name=f"{WHEEL}{i}", joint=f"{WHEEL}{i}")


def add_touches(contact: Element, world: Element, chain: ChainBody, margin_m: float) -> None:
    """Let each wheel touch each wall: pairs, wheel by wheel, which MuJoCo tests sooner."""
    walls = world.findall("geom")
    for number, wall in enumerate(walls):
        wall.set("name", f"{WALL}{number}")
    for i in range(chain.nodes):
        for wall in walls:
            SubElement(
                contact, "pair", geom1=wall.get("name", ""), geom2=f"{WHEEL}{i}",
                margin=numbers(margin_m),
            )  # fmt: skip


def _add_inertia(
    body: Element, mass_kg: float, along_m: float, inertia: tuple[float, float, float]
) -> None:
    place = numbers(along_m, 0, 0)
    SubElement(body, "inertial", pos=place, mass=numbers(mass_kg), diaginertia=numbers(*inertia))


def _add_shape(body: Element, chain: ChainBody, ends_m: tuple[float, float]) -> None:
    """Add what of a link can touch a wall; as in the kinematic simulator it slides there."""
    SubElement(
        body, "geom", type="capsule", fromto=numbers(ends_m[0], 0, 0, ends_m[1], 0, 0),
        size=numbers(chain.half_thickness_m), priority="2", condim="1",
        contype=LINK_BIT, conaffinity="0", rgba="0.8 0.5 0.2 1",
    )  # fmt: skip


# --- the model -----------------------------------------------------------------------------------


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
    settings = {"condim": "4", **_CONTACT_IN_SPACE} if space else {"condim": "3", **_CONTACT}
    for kind in ("geom", "pair"):
        SubElement(default, kind, settings)
    SubElement(default, "joint", _STIFF_JOINT)
    world = SubElement(model, "worldbody")
    actuators = Element("actuator")
    add_pipe(world, route, space=space)
    add_robot(world, actuators, chain, pose, space=space)
    model.append(actuators)
    contact = SubElement(model, "contact")
    add_touches(contact, world, chain, 0.0 if space else GIVES_WAY_M)
    return tostring(model, encoding="unicode")
