"""What each state writes to the wire, resolved to slots, signs, loops and levels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, inf

from pirate_sm.core._engine.robot.actuation_spec import (
    PositionSpec,
    SlotSpec,
    StageSpec,
    TorqueSpec,
    VelocitySpec,
    WheelTorqueSpec,
    Write,
)
from pirate_sm.core._engine.robot.criteria import AngleSet
from pirate_sm.core._engine.robot.robot_spec import Actuation, ChartTable, CommandSpec
from pirate_sm.core._engine.sensing.body_spec import BodySpec, Imu, Vee
from pirate_sm.core._geometry.space import GRAVITY_M_S2
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model.robot import profile as model
from pirate_sm.core._model.robot import signals as kinds
from pirate_sm.core._model.robot.actuation import (
    Duty,
    HeldTorque,
    Level,
    Setpoint,
    Share,
    Speed,
    Target,
)
from pirate_sm.core._model.robot.body import Motor
from pirate_sm.core.units import ANGLE, TORQUE


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
        body = profile.body
        speed = next((signals.index(w.speed) for w in body.wheels if w.name == slot.wheel), -1)
        return replace(
            duty,
            velocity=_velocity(motor, speed, body.wheel_radius),
            wheel_torque=_wheel_torque(motor, speed),
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
        rate=signals.derived_by(kinds.RateOf, rate_of=slot.joint),
        torque=torque,
        position=loop,
        held_torque=_held_torque(motor, torque),
    )


def _velocity(motor: Motor, speed: int, radius_m: float) -> VelocitySpec | None:
    """Return the velocity loop of a wheel by the number index of its speed; None without one."""
    loop, no_load_rad_s = motor.velocity_loop, motor.no_load_speed or inf
    if loop is None or speed < 0:
        return None
    stall_nm = motor.stall_torque or 0.0
    return VelocitySpec(loop.gain, loop.limit, no_load_rad_s, speed, radius_m, stall_nm)


def _wheel_torque(motor: Motor, speed: int) -> WheelTorqueSpec | None:
    """Return how a wheel is kept at a torque; None where it cannot be."""
    if speed < 0 or not motor.stall_torque or not motor.no_load_speed:
        return None
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


def resolve_chain(signals: Signals) -> BodySpec:
    """Return the robot's chain; unknown names are left out, and reported elsewhere."""
    profile, body = signals.profile, signals.profile.body
    sign = -1 if signals.polarity == "mirrored" else 1
    roll = next((link.roll for link in body.links if link.roll is not None), None)
    joints = {joint.wheel: signals.index(joint.name) for joint in body.joints}
    return BodySpec(
        lengths_m=tuple(link.length for link in body.links),
        joints=tuple(joints.get(wheel.name, -1) for wheel in body.wheels),
        sides=tuple(sign * wheel.direction for wheel in body.wheels),
        parts=tuple(_vee(profile, signals, name) for name in body.parts),
        wheel_radius_m=body.wheel_radius,
        roll_link=next((i for i, link in enumerate(body.links) if link.roll is not None), -1),
        imu=_imu(profile, signals),
        roll=signals.index(roll),
        weight_n=body.mass_kg * GRAVITY_M_S2,
        edge_lacks=body.edge_lacks,
    )


def _vee(profile: model.Profile, signals: Signals, name: str) -> Vee:
    body = profile.body
    apex = body.apex_of(name)
    return Vee(
        tuple(index for index, wheel in enumerate(body.wheels) if wheel.part == name),
        signals.index(apex.name if apex else None),
        signals.derived_by(kinds.DiameterOf, diameter_of=name),
        apex.end_stop if apex else 0.0,
    )


def _imu(profile: model.Profile, signals: Signals) -> Imu | None:
    """Return the accelerometer from which roll or pitch is derived; None without one."""
    for derived in profile.derived.values():
        if derived.OF == "axes":
            modules = [link.module for link in profile.body.links]
            module = next(
                (
                    board.module
                    for board in profile.boards
                    if {channel.signal for channel in board.channels} >= set(derived.sources)
                ),
                "",
            )
            if module not in modules:
                return None
            link = modules.index(module)
            x, y, z = map(signals.index, derived.sources)
            return Imu(link, (x, y, z), signals.index(profile.body.links[link].roll))
    return None


def resolve_actuation(table: ChartTable, signals: Signals, slots: Slots) -> Actuation:
    """Per region and state its stages; each state of a region writes the same slots.

    In mirrored polarity every slot that mirrors has the other sign.
    """
    result = []
    owners: dict[int, str] = {}
    for region, states in zip(table.regions, table.states, strict=True):
        resolved: dict[str, tuple[StageSpec, ...]] = {}
        for state in states:
            at: Path = ("actuation", region, state)
            stages = signals.profile.actuation[region][state]
            resolved[state] = tuple(
                resolve_stage(stage, signals, slots, (*at, number) if len(stages) > 1 else at)
                for number, stage in enumerate(stages)
            )
        _check_slots(region, resolved, slots, owners, signals.problems)
        result.append(resolved)
    return tuple(result)


def resolve_stage(
    stage: Mapping[str, Setpoint], signals: Signals, slots: Slots, at: Path
) -> StageSpec:
    """Return what the stage writes to the wire, or the problems say why it cannot be.

    A share of a joint's angle keeps its sign in mirrored polarity: the angle changes its own.
    """
    writes = []
    for name, setpoint in stage.items():
        index = slots.index(name, (*at, name))
        sign = -1.0 if signals.polarity == "mirrored" and slots.mirrors[index] else 1.0
        path: Path = (*at, name)
        write = _write(index, slots.specs[index], setpoint, sign, path, signals.problems)
        if isinstance(setpoint, Share):
            write = write._replace(share_of=_source(setpoint, signals, at, path))
        elif isinstance(setpoint, Level) and not levels(slots.specs[index], signals, path):
            write = Write(index, "keep", 0.0)
        writes.append(write)
    return tuple(writes)


def _source(share: Share, signals: Signals, at: Path, path: Path) -> int:
    """Number index of the joint's angle that a setpoint is a share of; -1 and a problem if none."""
    if at[0] != "postures":
        message = "a share of a joint's angle is for postures: in a state it could be unknown"
        signals.problems.add("robot.setpoint", path, message)
        return -1
    joints = [joint.name for joint in signals.profile.body.joints]
    if share.joint not in joints:
        signals.problems.add_unknown("robot.joint", path, "joint", share.joint, joints)
        return -1
    return signals.number(share.joint, path, ANGLE)


def _write(
    index: int, slot: SlotSpec, setpoint: Setpoint, sign: float, path: Path, problems: Problems
) -> Write:
    match setpoint:
        case Duty(value):
            if slot.unit != "duty":
                message = f"'{slot.name}' takes an angle, not a duty cycle"
                problems.add("robot.setpoint", path, message)
            return Write(index, "set", sign * value + 0.0)
        case Speed(value):
            return _speed(index, slot, sign * value, path, problems)
        case HeldTorque(value):
            return _torque(index, slot, sign * value + 0.0, path, problems)
        case Target(angle_rad):
            return _target(index, slot, sign * angle_rad + 0.0, path, problems)
        case Share(factor):
            return _target(index, slot, factor + 0.0, path, problems)
        case Level(angle_rad):
            return Write(index, "level", angle_rad + 0.0)
        case "keep":
            return Write(index, "keep", 0.0)


def _speed(index: int, slot: SlotSpec, value: float, path: Path, problems: Problems) -> Write:
    """Return what keeps the slot's wheel at a speed in m/s."""
    spec = slot.velocity
    if spec is None:
        message = f"'{slot.name}' has no wheel whose motor has a velocity loop to keep a speed"
        problems.add("robot.setpoint", path, message)
        return Write(index, "keep", 0.0)
    most = spec.no_load_rad_s * spec.limit * spec.radius_m
    if abs(value) > most:
        message = (
            f"{value * 1000:.4g} mm/s is more than '{slot.name}' reaches, {most * 1000:.4g} mm/s"
        )
        problems.add("robot.setpoint", path, message)
    return Write(index, "turn", value / spec.radius_m + 0.0)


def _torque(index: int, slot: SlotSpec, value: float, path: Path, problems: Problems) -> Write:
    """Return what keeps the slot's joint or wheel at a torque in Nm."""
    loop = slot.held_torque or slot.wheel_torque
    if loop is None:
        message = (
            f"'{slot.name}' cannot be kept at a torque: that takes a joint with a torque sensor"
            " and a motor with a `torque_loop`, or a wheel's motor with `stall_torque` and"
            " `no_load_speed`"
        )
        problems.add("robot.setpoint", path, message)
        return Write(index, "keep", 0.0)
    most = loop.stall_torque_nm * (slot.held_torque.limit if slot.held_torque else 1.0)
    if abs(value) > most:
        message = (
            f"{abs(value) * 1000:.4g} mNm is more than '{slot.name}' can bear at its limit,"
            f" {most * 1000:.4g} mNm"
        )
        problems.add("robot.setpoint", path, message)
    return Write(index, "bear", value)


def _target(index: int, slot: SlotSpec, angle_rad: float, path: Path, problems: Problems) -> Write:
    """Return what brings the slot to an angle: its board's own controller, or our loop."""
    if slot.unit == "angle":
        if abs(angle_rad) > slot.high:
            angle, most = degrees(angle_rad), degrees(slot.high)
            message = f"{angle:.4g} deg is beyond the limit of '{slot.name}', {most:.4g} deg"
            problems.add("robot.setpoint", path, message)
        return Write(index, "set", angle_rad)
    if slot.position is None:
        message = (
            f"'{slot.name}' takes a duty cycle: its motor has no position loop to hold an angle"
        )
        problems.add("robot.setpoint", path, message)
    return Write(index, "seek", angle_rad)


def _check_slots(
    region: str,
    states: Mapping[str, tuple[StageSpec, ...]],
    slots: Slots,
    owners: dict[int, str],
    problems: Problems,
) -> None:
    """All stages of a region write the same slots, and no two regions write one."""
    every = {write.slot for stages in states.values() for stage in stages for write in stage}
    for state, stages in states.items():
        for stage in stages:
            missing = sorted(every - {write.slot for write in stage})
            if missing:
                names = ", ".join(slots.specs[slot].name for slot in missing)
                problems.add(
                    "robot.actuation", ("actuation", region, state),
                    f"other states of {region} write {names}, this one does not",
                )  # fmt: skip
    for slot in sorted(every):
        if owners.setdefault(slot, region) != region:
            at: Path = next(
                ("actuation", region, state, *((number,) if len(stages) > 1 else ()))
                for state, stages in states.items()
                for number, stage in enumerate(stages)
                if slot in {write.slot for write in stage}
            )
            message = f"'{slots.specs[slot].name}' is written by {owners[slot]} too"
            problems.add("robot.actuation", (*at, slots.specs[slot].name), message, key=True)


def levels(slot: SlotSpec, signals: Signals, path: Path) -> bool:
    """Return whether a slot can level a part; report one that cannot.

    It turns a roll joint, ahead of which an accelerometer sits.
    """
    imu = _imu(signals.profile, signals)
    if slot.unit == "angle" and imu is not None and slot.angle >= 0 and imu.roll == slot.angle:
        return True
    message = (
        f"'{slot.name}' cannot level a part: that takes a slot with `unit: angle` that turns a"
        " roll joint, and on that joint's link the accelerometer of a derived signal"
        " `roll_of` or `pitch_of`"
    )
    signals.problems.add("robot.setpoint", path, message)
    return False


def check_levelled(
    table: ChartTable,
    actuation: Actuation,
    commands: Sequence[CommandSpec],
    problems: Problems,
) -> None:
    """Report commands that lead to a levelled state and are not done by its angle."""
    for number, spec in enumerate(commands):
        slots = {each.slot for each in spec.done.asked(AngleSet)}
        if not slots.issuperset(_levelled(table, actuation, number)):
            message = (
                f"{spec.name} levels a part, so its criterion must be `kind: aligned` with the"
                " slot that turns it"
            )
            problems.add("robot.criterion", ("commands", spec.name, "done"), message)


def _levelled(table: ChartTable, actuation: Actuation, command: int) -> Iterator[int]:
    """Yield the slots that are levelled in the states that the command enters."""
    for here, states in enumerate(table.configurations):
        after = table.configurations[table.follow(here, command)]
        for region, (old, new) in enumerate(zip(states, after, strict=True)):
            for stage in actuation[region][new] if new != old else ():
                yield from (write.slot for write in stage if write.how == "level")
