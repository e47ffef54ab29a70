"""A chain as MuJoCo's bodies: links with wheels on their ends, springs and motors.

Frames: x of a link points ahead, y to side A, z is the axle of wheels and joints. The first wheel
is the origin of the first link; each further link has its own origin in the wheel ahead of it.
"""

from __future__ import annotations

import math
from xml.etree.ElementTree import Element, SubElement

from pirate_sm.simulation.mechanics import ChainBody, LinkBody
from pirate_sm.simulation.mujoco.names import (
    BEND,
    LINK,
    LINK_BIT,
    ROLL,
    ROLL_REAR,
    WHEEL,
    WHEEL_BIT,
    X_DRAG,
    Y_DRAG,
    numbers,
)
from pirate_sm.simulation.physics import StartPose

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
    margin_m = 0.0 if space else GIVES_WAY_M
    if space:
        SubElement(body, "freejoint", name="root")
    else:
        for name, kind, axis in (("x", "slide", "1 0 0"), ("y", "slide", "0 1 0")):
            SubElement(body, "joint", name=name, type=kind, axis=axis)
        SubElement(body, "joint", name="heading", type="hinge", axis="0 0 1")
    last = len(chain.links) - 1
    for m, link in enumerate(chain.links):
        _add_wheel(body, actuators, chain, m, m, 0.0, margin_m)
        rear_m = -link.length_m
        if space and m == chain.roll_link:
            body = _add_roll_joint(body, actuators, chain, link)
            rear_m = -link.length_m / 2
        else:
            _add_link(body, chain, link)
        _add_wheel(body, actuators, chain, m, m + 1, rear_m, margin_m)
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
    margin_m: float,
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
        contype=WHEEL_BIT, conaffinity="0", margin=numbers(margin_m), rgba="0.2 0.2 0.2 1",
    )  # fmt: skip
    SubElement(actuators, "motor", name=f"{WHEEL}{i}", joint=f"{WHEEL}{i}")


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
