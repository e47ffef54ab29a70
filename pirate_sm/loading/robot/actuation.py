"""What each state writes to the wire, resolved to slots, signs and position loops."""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from typing import Literal

from pirate_sm.engine.robot.chart_table import ChartTable
from pirate_sm.engine.robot.robot_spec import SlotSpec, StageSpec, Write
from pirate_sm.loading.problems import Path, Problems
from pirate_sm.loading.robot.signals import Signals
from pirate_sm.loading.robot.slots import Slots
from pirate_sm.model.actuation import KEEP, Duty, Setpoint, Share, Target
from pirate_sm.model.profile import Profile
from pirate_sm.spelling import nearest, one_of
from pirate_sm.units import ANGLE


def resolve_actuation(
    profile: Profile,
    table: ChartTable,
    signals: Signals,
    slots: Slots,
    polarity: Literal["normal", "mirrored"],
    problems: Problems,
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
            stages = profile.actuation[region][state]
            resolved[state] = tuple(
                resolve_stage(
                    stage,
                    profile,
                    signals,
                    slots,
                    polarity,
                    (*at, number) if len(stages) > 1 else at,
                    problems,
                )
                for number, stage in enumerate(stages)
            )
        _check_slots(region, resolved, slots, owners, problems)
        result.append(resolved)
    return tuple(result)


def resolve_stage(
    stage: Mapping[str, Setpoint],
    profile: Profile,
    signals: Signals,
    slots: Slots,
    polarity: Literal["normal", "mirrored"],
    at: Path,
    problems: Problems,
) -> StageSpec:
    """Return what the stage writes to the wire, or the problems say why it cannot be.

    A share of a joint's angle keeps its sign in mirrored polarity: the angle changes its own.
    """
    writes = []
    for name, setpoint in stage.items():
        index = slots.index(name, (*at, name))
        sign = -1.0 if polarity == "mirrored" and slots.mirrors[index] else 1.0
        path: Path = (*at, name)
        if isinstance(setpoint, Share):
            source = _source(profile, setpoint, signals, at, path, problems)
            factor = Target(setpoint.factor)
            write = _write(index, slots.specs[index], factor, 1.0, path, problems)
            writes.append(write._replace(share_of=source))
        else:
            writes.append(_write(index, slots.specs[index], setpoint, sign, path, problems))
    return tuple(writes)


def _source(
    profile: Profile, share: Share, signals: Signals, at: Path, path: Path, problems: Problems
) -> int:
    """Number index of the joint's angle that a setpoint is a share of; -1 and a problem if none."""
    if at[0] != "postures":
        message = "a share of a joint's angle is for postures: in a state it could be unknown"
        problems.add("robot.setpoint", path, message)
        return -1
    joints = [joint.name for joint in profile.body.joints]
    if share.joint not in joints:
        problems.add(
            "robot.joint", path, f"there is no joint '{share.joint}'",
            expected=one_of(joints), suggestion=nearest(share.joint, joints) or "",
        )  # fmt: skip
        return -1
    return signals.number(share.joint, path, ANGLE)


def _write(
    index: int, slot: SlotSpec, setpoint: Setpoint, sign: float, path: Path, problems: Problems
) -> Write:
    if setpoint == KEEP:
        return Write(index, "keep", 0.0)
    if isinstance(setpoint, Duty):
        if slot.unit != "duty":
            problems.add("robot.setpoint", path, f"'{slot.name}' takes an angle, not a duty cycle")
        return Write(index, "set", sign * setpoint.value + 0.0)
    assert isinstance(setpoint, Target)
    if slot.unit == "angle":
        if abs(setpoint.angle_rad) > slot.high:
            angle, most = degrees(setpoint.angle_rad), degrees(slot.high)
            message = f"{angle:.4g} deg is beyond the limit of '{slot.name}', {most:.4g} deg"
            problems.add("robot.setpoint", path, message)
        return Write(index, "set", sign * setpoint.angle_rad + 0.0)
    if slot.loop is None:
        problems.add(
            "robot.setpoint", path,
            f"'{slot.name}' takes a duty cycle: its motor has no position loop to hold an angle",
        )  # fmt: skip
    return Write(index, "seek", sign * setpoint.angle_rad + 0.0)


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
            problems.add(
                "robot.actuation", ("actuation", region),
                f"'{slots.specs[slot].name}' is written by {owners[slot]} too", key=True,
            )  # fmt: skip
