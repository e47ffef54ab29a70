"""A robot's profile becomes what the simulator moves: a chain, motors behind slots, channels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pirate_sm.backends.simulator import kernel
from pirate_sm.backends.simulator.arrays import Floats
from pirate_sm.backends.simulator.chain import ChainBody, JointBody, Layout, LinkBody, WheelBody
from pirate_sm.errors import UsageError
from pirate_sm.expressions import Vocabulary, compile_expression
from pirate_sm.model import derived as kinds
from pirate_sm.model import profile as model

# Assumed, as nobody measured it: enough to let a free bend joint swing once.
JOINT_DAMPING_NMS_RAD = 0.02


class Route(NamedTuple):
    """Where a setpoint goes.

    Attributes:
        command: Index in the kernel's command array, -1 for the roll joint, -2 for nothing that
            moves.
        low: Least value that is accepted, duty or rad.
        high: Largest value.
        step: Resolution of the wire.
    """

    command: int
    low: float
    high: float
    step: float


NOWHERE, ROLL = -2, -1


class BoardChannels(NamedTuple):
    """A board that reports, and which rows of the channel table are its own."""

    board: int
    first: int
    last: int


@dataclass(frozen=True)
class Machine:
    """A simulated robot, before anything of it has moved.

    Attributes:
        chain: Its body.
        routes: Per slot in the order of the wire.
        boards: Boards that report, in the order in which they do.
        channels: `(channels, kernel.CHANNEL_COLUMNS)`, boards one after the other.
        places: Row of the channel table by the name of the signal.
        wheels: Index of each wheel by name.
        joints: Index of the wheel that each bend joint sits at, by the joint's name.
    """

    chain: ChainBody
    routes: tuple[Route, ...]
    boards: tuple[BoardChannels, ...]
    channels: Floats
    places: dict[str, int]
    wheels: dict[str, int]
    joints: dict[str, int]


def machine_of(profile: model.Profile) -> Machine:
    """The profile's robot can be simulated.

    Raises:
        UsageError: The profile lacks a number that only a simulator needs; says which.
    """
    body = profile.body
    wheels = {wheel.name: i for i, wheel in enumerate(body.wheels)}
    joints = {joint.name: wheels[joint.wheel] for joint in body.joints}
    chain = _chain(profile, wheels, joints)
    rows: list[tuple[float, ...]] = []
    places: dict[str, int] = {}
    boards: list[BoardChannels] = []
    for board in profile.boards:
        if not (board.fitted and board.channels_fitted and board.channels):
            continue
        first = len(rows)
        for channel in board.channels:
            if channel.signal is not None:
                places[channel.signal] = len(rows)
            rows.append(_channel(profile, channel, chain, wheels, joints))
        boards.append(BoardChannels(board.id, first, len(rows)))
    return Machine(
        chain,
        tuple(_route(profile, slot, wheels, joints) for slot in profile.slots),
        tuple(boards),
        np.array(rows, dtype=np.float64).reshape(len(rows), kernel.CHANNEL_COLUMNS),
        places,
        wheels,
        joints,
    )


def _needed(value: float | None, motor: str, field: str) -> float:
    if value is None:
        raise UsageError(f"motors.{motor} needs {field} to be simulated")
    return value


def _chain(profile: model.Profile, wheels: dict[str, int], joints: dict[str, int]) -> ChainBody:
    body = profile.body
    modules = [link.module for link in body.links]
    made: dict[int, WheelBody] = {}
    springs: dict[int, JointBody] = {}
    roll_rate = roll_stall = 0.0
    stops = {joint.name: joint.end_stop for joint in body.joints}
    for board in profile.boards:
        for slot in board.slots:
            motor = profile.motors[slot.motor]
            if slot.wheel is not None:
                i = wheels[slot.wheel]
                made[i] = WheelBody(
                    body.wheels[i].mass,
                    _motor_link(modules, board.module, i),
                    _needed(motor.no_load_speed, slot.motor, "no_load_speed"),
                    _needed(motor.stall_torque, slot.motor, "stall_torque"),
                    _needed(motor.hold_torque, slot.motor, "hold_torque"),
                    _needed(motor.dead_drag, slot.motor, "dead_drag"),
                )
            elif slot.joint is not None:
                springs[joints[slot.joint]] = JointBody(
                    _needed(motor.stiffness, slot.motor, "stiffness"),
                    _needed(motor.no_load_speed, slot.motor, "no_load_speed"),
                    _needed(motor.stall_torque, slot.motor, "stall_torque"),
                    stops[slot.joint],
                    damping_nms_rad=JOINT_DAMPING_NMS_RAD,
                )
            elif slot.roll is not None:
                roll_rate = _needed(motor.no_load_speed, slot.motor, "no_load_speed")
                roll_stall = _needed(motor.stall_torque, slot.motor, "stall_torque")
    for i, wheel in enumerate(body.wheels):
        made.setdefault(i, WheelBody(wheel.mass, max(i - 1, 0), 0.0, 1.0, 0.0, 0.0))
    return ChainBody(
        tuple(made[i] for i in range(len(body.wheels))),
        tuple(LinkBody(link.length, link.mass) for link in body.links),
        springs,
        body.wheel_radius,
        body.body_half_thickness,
        next((m for m, link in enumerate(body.links) if link.roll is not None), -1),
        roll_rate or 1.0,
        roll_stall or 1.0,
    )


def _motor_link(modules: Sequence[str], module: str, wheel: int) -> int:
    """The link that carries a wheel's motor: that of the board's module, else the one ahead."""
    near = [m for m in (wheel - 1, wheel) if 0 <= m < len(modules)]
    return next((m for m in near if modules[m] == module), near[0])


def _route(
    profile: model.Profile, slot: model.Slot, wheels: dict[str, int], joints: dict[str, int]
) -> Route:
    link = profile.link
    if slot.unit == "angle":
        limit = slot.limit if slot.limit is not None else 7.0
        to = ROLL if slot.roll is not None else NOWHERE
        return Route(to, -limit, limit, link.angle_resolution)
    to = NOWHERE
    if slot.wheel is not None:
        to = len(wheels) + wheels[slot.wheel]
    elif slot.joint is not None:
        to = joints[slot.joint]
    return Route(to, -1.0, 1.0, link.duty_resolution)


def scale_of(text: str) -> float:
    """The SI value of a constant expression such as ``360 deg / 4096``."""
    value = compile_expression(text, Vocabulary({})).evaluate((), ())
    if not isinstance(value, float):
        raise UsageError(f"'{text}' is not a number")
    return value


def _channel(
    profile: model.Profile,
    channel: model.Channel,
    chain: ChainBody,
    wheels: dict[str, int],
    joints: dict[str, int],
) -> tuple[float, ...]:
    """A row of the channel table: the inverse of the profile's conversion from raw to SI."""
    layout = Layout(chain.nodes)
    noise = profile.simulation.noise
    per_count = scale_of(profile.conversions[channel.convert].scale) if channel.convert else 1.0
    slot = next((slot for slot in profile.slots if slot.name == channel.slot), None)
    senses = channel.senses
    if senses is None:
        return (0.0, 0.0, 0.0, 0.0, 0.0)
    if slot is None:
        sigma = noise.acceleration if senses.startswith("acc") else 0.0
        return (layout.at(senses), 1.0 / per_count, 0.0, sigma / per_count, 0.0)
    at = wheels[slot.wheel] if slot.wheel is not None else joints.get(slot.joint or "", 0)
    if senses == "current":
        source, gain = _current(profile, channel, slot, layout, at)
        return (source, gain / per_count, 0.0, noise.current / per_count, 1.0)
    if slot.wheel is not None:
        return (layout.at("wheel" if senses == "angle" else "turned", at), 1.0 / per_count, 0, 0, 0)
    if slot.joint is None:
        return (layout.at("roll"), 1.0 / per_count, 0, 0, 0)
    sigma = noise.angle
    quantity = "bend"
    if senses == "torque":
        # The spring is read as a difference of two angles.
        quantity = "bend_torque"
        sigma *= chain.joints[at].stiffness_nm_rad
    return (layout.at(quantity, at), 1.0 / per_count, 0.0, sigma / per_count, 0.0)


def _current(
    profile: model.Profile, channel: model.Channel, slot: model.Slot, layout: Layout, at: int
) -> tuple[int, float]:
    """The quantity that a motor's current follows, and amperes per unit of it."""
    motor = profile.motors[slot.motor]
    stall_a = _needed(motor.stall_current, slot.motor, "stall_current")
    if slot.joint is not None:
        return layout.at("bend_current", at), stall_a
    if slot.wheel is None:
        return layout.at("roll_current"), stall_a
    for derived in profile.derived.values():
        if isinstance(derived, kinds.TorqueOf) and derived.torque_of == channel.signal:
            # The reported current must read back the torque applied (thesis eq. 5-3).
            return layout.at("drive", at), 1.0 / scale_of(derived.scale)
    stall_nm = _needed(motor.stall_torque, slot.motor, "stall_torque")
    return layout.at("drive", at), stall_a / stall_nm
