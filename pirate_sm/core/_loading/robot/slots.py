"""Resolve the slots of the wire: what each drives, its limits and its control loops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf

from pirate_sm.core._engine.robot.command_spec import (
    PositionSpec,
    SlotSpec,
    TorqueSpec,
    VelocitySpec,
    WheelTorqueSpec,
)
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model import profile as model
from pirate_sm.core._model.motor import Motor
from pirate_sm.core.units import ANGLE, ANGULAR_SPEED, TORQUE


@dataclass(frozen=True)
class Slots:
    """The resolved slots, found by name."""

    specs: tuple[SlotSpec, ...]
    mirrors: tuple[bool, ...]
    problems: Problems

    def index(self, name: str, path: Path) -> int:
        """Return the slot's index on the wire; 0 after reporting an unknown name."""
        names = [slot.name for slot in self.specs]
        if name in names:
            return names.index(name)
        self.problems.add_unknown("robot.slot", path, "slot", name, names)
        return 0


def resolve_slots(signals: Signals) -> Slots:
    """Return the slots with their limits, signals and loops; report their faults."""
    profile = signals.profile
    specs = [
        _slot(signals, slot, ("boards", number, "slots", place))
        for number, board in enumerate(profile.boards)
        for place, slot in enumerate(board.slots)
    ]
    return Slots(tuple(specs), tuple(slot.mirrors for slot in profile.slots), signals.problems)


def _slot(signals: Signals, slot: model.Slot, path: Path) -> SlotSpec:
    profile, problems = signals.profile, signals.problems
    motor = profile.motors[slot.motor]
    known = _check_targets(profile, slot, path, problems)
    link = profile.link
    if slot.unit == "angle":
        limit = slot.limit if slot.limit is not None else inf
        angle = signals.number(slot.roll, (*path, "roll"), ANGLE) if slot.roll and known else -1
        return SlotSpec(
            slot.name, "angle", -limit, limit, link.angle_resolution, angle, drives=slot.drives
        )
    locks = motor.kind == "sprung_worm"
    resolution = link.duty_resolution
    duty = SlotSpec(
        slot.name, "duty", -1.0, 1.0, resolution, self_locking=locks, drives=slot.drives
    )
    if slot.joint is None:
        return replace(
            duty,
            velocity=_velocity(signals, slot, motor, path),
            wheel_torque=_wheel_torque(signals, slot, motor, path),
        )
    joints = profile.body.joints
    place = next((n for n, joint in enumerate(joints) if joint.name == slot.joint), -1)
    name = joints[place].torque if place >= 0 else None
    torque_path: Path = ("body", "joints", place, "torque")
    torque = signals.number(name, torque_path, TORQUE) if name else -1
    loop, settings = None, motor.position_loop
    if settings is not None:
        loop = PositionSpec(
            settings.gain,
            settings.threshold,
            settings.least_duty,
            settings.limit,
            motor.stall_torque or inf,
            settings.unmoved_limit or 0.0,
        )
    return replace(
        duty,
        angle=signals.number(slot.joint, (*path, "joint"), ANGLE) if known else -1,
        rate=signals.rate_of(slot.joint),
        torque=torque,
        position=loop,
        held_torque=_held_torque(motor, torque),
    )


def _velocity(signals: Signals, slot: model.Slot, motor: Motor, path: Path) -> VelocitySpec | None:
    """Return the velocity loop of the slot's wheel; None without one."""
    settings, body = motor.velocity_loop, signals.profile.body
    wheel = next((each for each in body.wheels if each.name == slot.wheel), None)
    if settings is None or wheel is None:
        return None
    speed = signals.number(wheel.speed, (*path, "wheel"), ANGULAR_SPEED)
    no_load_rad_s = motor.no_load_speed or inf
    radius_m = body.wheel_radius
    stall_nm = motor.stall_torque or 0.0
    return VelocitySpec(settings.gain, settings.limit, no_load_rad_s, speed, radius_m, stall_nm)


def _wheel_torque(
    signals: Signals, slot: model.Slot, motor: Motor, path: Path
) -> WheelTorqueSpec | None:
    """Return how the slot's wheel is kept at a torque; None where it cannot be."""
    wheels = signals.profile.body.wheels
    wheel = next((each for each in wheels if each.name == slot.wheel), None)
    if wheel is None or not motor.stall_torque or not motor.no_load_speed:
        return None
    speed = signals.number(wheel.speed, (*path, "wheel"), ANGULAR_SPEED)
    return WheelTorqueSpec(motor.stall_torque, motor.no_load_speed, speed)


def _held_torque(motor: Motor, torque: int) -> TorqueSpec | None:
    """Return how a joint is kept at a torque; None without a loop, or without its sensor."""
    loop = motor.torque_loop
    if loop is None or motor.stall_torque is None or torque < 0:
        return None
    duties = loop.least_duty, loop.limit
    return TorqueSpec(loop.gain, loop.dead, loop.within, *duties, motor.stall_torque, torque)


_SAID = {"joint": "joint", "wheel": "wheel", "roll": "roll joint"}


def _check_targets(
    profile: model.Profile, slot: model.Slot, path: Path, problems: Problems
) -> bool:
    """Return whether the joint or wheel that the slot drives exists; report it otherwise."""
    known = True
    valid = {
        "joint": [joint.name for joint in profile.body.joints],
        "wheel": [wheel.name for wheel in profile.body.wheels],
        "roll": [link.roll for link in profile.body.links if link.roll],
    }
    for kind, names in valid.items():
        name, said = getattr(slot, kind), _SAID[kind]
        if name is not None and name not in names:
            known = False
            message, none = f"the body has no {said} '{name}'", f"no slot for a {said}"
            at = (*path, kind)
            problems.add_unknown(f"robot.{kind}", at, said, name, names, message=message, none=none)
    return known
