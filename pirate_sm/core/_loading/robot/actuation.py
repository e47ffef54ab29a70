"""What each state writes to the wire, resolved to slots, signs, loops and levels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import degrees

from pirate_sm.core._engine.robot.command_spec import CommandSpec, SlotSpec, StageSpec, Write
from pirate_sm.core._engine.robot.criteria import AlignedSpec
from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.body_chain import resolve_chain
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._loading.robot.slots import Slots
from pirate_sm.core._model.actuation import Duty, HeldTorque, Level, Setpoint, Share, Speed, Target
from pirate_sm.core.units import ANGLE


def resolve_actuation(
    table: ChartTable, signals: Signals, slots: Slots
) -> tuple[Mapping[str, tuple[StageSpec, ...]], ...]:
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
    imu = resolve_chain(signals).imu
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
    actuation: Sequence[Mapping[str, tuple[StageSpec, ...]]],
    commands: Sequence[CommandSpec],
    problems: Problems,
) -> None:
    """Report commands that lead to a levelled state and are not done by its angle."""
    for number, spec in enumerate(commands):
        slots = {slot for slot, _ in spec.done.slots} if isinstance(spec.done, AlignedSpec) else {}
        levelled = {*_levelled(table, actuation, number)}
        if not levelled <= {*slots}:
            message = (
                f"{spec.name} levels a part, so its criterion must be `kind: aligned` with the"
                " slot that turns it"
            )
            problems.add("robot.criterion", ("commands", spec.name, "done"), message)


def _levelled(
    table: ChartTable, actuation: Sequence[Mapping[str, tuple[StageSpec, ...]]], command: int
) -> Iterator[int]:
    """Yield the slots that are levelled in the states that the command enters."""
    for here, states in enumerate(table.configurations):
        after = table.configurations[table.follow(here, command)]
        for region, (old, new) in enumerate(zip(states, after, strict=True)):
            for stage in actuation[region][new] if new != old else ():
                yield from (write.slot for write in stage if write.how == "level")
