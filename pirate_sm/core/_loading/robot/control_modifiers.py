"""Resolve what a control adds to every state: gravity compensation and grip."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, nan
from typing import NamedTuple

from pirate_sm.core._engine.robot.command_spec import GripSpec, SlotSpec, StageSpec, Write
from pirate_sm.core._engine.robot.robot_spec import Actuation
from pirate_sm.core._geometry.space import GRAVITY_M_S2
from pirate_sm.core._loading.problems import Path
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._loading.robot.slots import Slots
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model.control import Control, Grip


class Modifiers(NamedTuple):
    """What a control adds to every state.

    Attributes:
        owner: The control whose ``grip`` it is.
    """

    gravity_compensation: bool = False
    grip: Grip | None = None
    owner: str = ""


def inherited(control: Control, known: Mapping[str, Modifiers], name: str = "") -> Modifiers:
    """Return what a control adds: its own, else that of the control that it extends."""
    base = known.get(control.extends or "", Modifiers())
    compensates = control.gravity_compensation
    grip, owner = (control.grip, name) if control.grip else (base.grip, base.owner)
    return Modifiers(base.gravity_compensation if compensates is None else compensates, grip, owner)


def modified(
    actuation: Actuation, name: str, added: Modifiers, signals: Signals, slots: Slots
) -> Actuation:
    """Return the actuation with what the control adds to it, or report why that cannot be."""
    grips = _grips(added.grip, added.owner, signals, slots) if added.grip else {}
    assists = _assists(signals) if added.gravity_compensation else {}
    if added.gravity_compensation:
        _check_motors(actuation, name, signals, slots)

    def changed(write: Write) -> Write:
        if write.how == "bear" and write.value != 0 and write.slot in grips:
            write = write._replace(grip=grips[write.slot])
        if write.turns and write.how in ("turn", "bear") and write.slot in assists:
            write = write._replace(assist_nm=assists[write.slot])
        return write

    def stages(given: tuple[StageSpec, ...]) -> tuple[StageSpec, ...]:
        return tuple(tuple(map(changed, stage)) for stage in given)

    return tuple({state: stages(each) for state, each in states.items()} for states in actuation)


def weight_n(signals: Signals) -> float:
    """Return the weight of the robot."""
    return signals.profile.body.mass_kg * GRAVITY_M_S2


def _assists(signals: Signals) -> dict[int, float]:
    """Return by slot the torque by which each wheel bears its share of the weight, upright."""
    share_n = weight_n(signals) / len(signals.profile.body.wheels)
    return {wheel.slot: share_n * wheel.metres_per_rad for wheel in signals.wheels}


def _check_motors(actuation: Actuation, name: str, signals: Signals, slots: Slots) -> None:
    """Report wheels whose motor's stall torque is not known, so that nothing can be added."""
    writes = (w for states in actuation for each in states.values() for s in each for w in s)
    turned = {write.slot for write in writes if write.how == "turn"}
    for slot in sorted(turned):
        spec: SlotSpec = slots.specs[slot]
        if spec.velocity is not None and not spec.velocity.stall_nm:
            message = f"gravity compensation needs the `stall_torque` of the motor of '{spec.name}'"
            path: Path = ("controls", name, "gravity_compensation")
            signals.problems.add("robot.control", path, message)


def _grips(grip: Grip, name: str, signals: Signals, slots: Slots) -> dict[int, GripSpec]:
    """Return by slot how hard each part's apex presses."""
    profile, names = signals.profile, signals.vocabulary.numbers
    body, path = profile.body, ("controls", name, "grip")
    if isinstance(grip.friction, dict):
        for part in [*body.parts, *grip.friction]:
            if part not in grip.friction or part not in body.parts:
                at: Path = (*path, "friction")
                message = f"give the friction of each part, {', '.join(body.parts)}"
                signals.problems.add("robot.control", at, message)
                return {}
    found: dict[int, GripSpec] = {}
    for part, settings in body.parts.items():
        wheels = [wheel.name for wheel in body.wheels if wheel.part == part]
        slot = next((i for i, s in enumerate(profile.slots) if s.joint == settings.apex), None)
        if slot is None or settings.apex not in names:
            continue
        estimates, slips, speed = _estimates(signals, wheels)
        if grip.friction == "estimate" and not estimates:
            message = f"friction is estimated by `friction_of` a wheel of {part}; there is none"
            signals.problems.add("robot.control", (*path, "friction"), message)
        held = slots.specs[slot].held_torque
        bears_nm = inf if held is None else held.limit * held.stall_torque_nm
        at_most_nm = max(bears_nm if grip.at_most is None else grip.at_most, grip.at_least)
        if at_most_nm > bears_nm:
            key = "at_least" if grip.at_most is None else "at_most"
            message = f"'{slots.specs[slot].name}' can bear {bears_nm * 1000:.4g} mNm at its limit"
            signals.problems.add("robot.control", (*path, key), message)
        found[slot] = GripSpec(
            safety=grip.safety,
            friction=grip.friction[part] if isinstance(grip.friction, dict) else nan,
            estimates=estimates,
            slip_speeds=slips,
            speed=speed,
            angle=names.index(settings.apex),
            leg_m=body.legs_m(part)[0],
            weight_n=weight_n(signals),
            wheels=len(body.wheels),
            share=1.0 if grip.share == "as_printed" else 2.0,
            at_least_nm=grip.at_least,
            at_most_nm=at_most_nm,
            alarm_m_s=grip.alarm,
            lower_nm_s=at_most_nm / grip.lower_within,
        )
    return found


def _estimates(signals: Signals, wheels: list[str]) -> tuple[tuple[int, ...], tuple[int, ...], int]:
    """Return the number indexes of the friction and of the slip speed of these wheels.

    The last one is that of the body speed that slip is counted from.
    """
    names = signals.vocabulary.numbers
    frictions, slips, body = [], [], -1
    for name, derived in signals.profile.derived.items():
        match derived:
            case kinds.FrictionOf(friction_of=wheel) if wheel in wheels:
                frictions.append(names.index(name))
            case kinds.SlipSpeedOf(slip_speed_of=wheel, speed=speed) if wheel in wheels:
                slips.append(names.index(name))
                body = names.index(speed) if speed in names else body
            case _:
                pass
    return tuple(frictions), tuple(slips), body
