"""Resolve what overlays the actuation of states: a robot's controls, and postures of commands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf, nan
from typing import NamedTuple

from pirate_sm.core._engine.robot.actuation_spec import GripSpec, SlotSpec, StageSpec, Write
from pirate_sm.core._engine.robot.robot_spec import (
    USUAL,
    Actuation,
    ChartTable,
    ControlSpec,
    PostureSpec,
)
from pirate_sm.core._geometry.space import GRAVITY_M_S2
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.actuation import Slots, resolve_stage
from pirate_sm.core._loading.robot.commands import is_true, on_states
from pirate_sm.core._loading.robot.criteria import resolve_criterion
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model.robot import signals as kinds
from pirate_sm.core._model.robot.actuation import Control, Grip, Level, PostureCase, Share, Target


def resolve_controls(
    table: ChartTable, signals: Signals, slots: Slots, usual: Actuation
) -> tuple[ControlSpec, ...]:
    """Return the robot's controls in the order of the profile, or report what is wrong.

    A control says how a state actuates its motors, not what the state is: each overlaid state keeps
    its slots, its number of stages and the wheels that it drives, and waits for no angle.
    """
    profile, problems = signals.profile, signals.problems
    joints = {part.apex for part in profile.body.parts.values()}
    apexes = frozenset(i for i, slot in enumerate(profile.slots) if slot.joint in joints)
    found: dict[str, Actuation] = {}
    specs: list[ControlSpec] = []
    modifiers: dict[str, Modifiers] = {}
    for name, control in profile.controls.items():
        if name == USUAL:
            message = f"'{USUAL}' is how a mission asks for the default actuation: use another name"
            problems.add("robot.control", ("controls", name), message, key=True)
        base = _base(name, control, found, usual, problems)
        overlaid = [dict(states) for states in base]
        for region, states in control.actuation.items():
            at: Path = ("controls", name, "actuation", region)
            if region not in table.regions:
                problems.add_unknown("robot.control", at, "region", region, table.regions, key=True)
                continue
            place = table.regions.index(region)
            for state, stages in states.items():
                path: Path = (*at, state)
                if state not in usual[place]:
                    known = list(usual[place])
                    problems.add_unknown("robot.control", path, "state", state, known, key=True)
                    continue
                resolved = []
                for number, stage in enumerate(stages):
                    here: Path = (*path, number) if len(stages) > 1 else path
                    for slot, setpoint in stage.items():
                        if isinstance(setpoint, Target | Share | Level):
                            message = "a control takes duty cycles, speeds and torques, no angles"
                            problems.add("robot.control", (*here, slot), message)
                    resolved.append(resolve_stage(stage, signals, slots, here))
                _check_overlay(usual[place][state], tuple(resolved), slots, apexes, path, problems)
                overlaid[place][state] = tuple(resolved)
        found[name] = tuple(overlaid)
        modifiers[name] = _inherited(control, modifiers, name)
        specs.append(
            ControlSpec(name, _modified(found[name], name, modifiers[name], signals, slots))
        )
    return tuple(specs)


def _base(
    name: str, control: Control, found: dict[str, Actuation], usual: Actuation, problems: Problems
) -> Actuation:
    """Return the actuation that the control changes; its base stands before it in the file."""
    if control.extends is None:
        return usual
    if control.extends not in found:
        problems.add_unknown(
            "robot.control",
            ("controls", name, "extends"),
            "control before this one",
            control.extends,
            found,
            none="no control before this one",
        )
    return found.get(control.extends, usual)


def _check_overlay(
    usual: tuple[StageSpec, ...],
    given: tuple[StageSpec, ...],
    slots: Slots,
    apexes: frozenset[int],
    path: Path,
    problems: Problems,
) -> None:
    """Report where a control makes something else of a state than another way to actuate it."""
    if len(usual) != len(given):
        message = f"the state has {len(usual)} stages, under this control {len(given)}"
        problems.add("robot.control", path, message)
        return
    for before, after in zip(usual, given, strict=True):
        wanted, got = ({write.slot for write in stage} for stage in (before, after))
        names = ", ".join(slots.specs[slot].name for slot in sorted(wanted ^ got))
        if names:
            problems.add("robot.control", path, f"write the same slots as `actuation`, not {names}")
        if not names:
            _check_ways(before, after, slots, apexes, path, problems)


def _check_ways(
    before: StageSpec,
    after: StageSpec,
    slots: Slots,
    apexes: frozenset[int],
    path: Path,
    problems: Problems,
) -> None:
    """Report motors that turn the other way than usual, other wheels, and parts that let go."""
    given = {write.slot: write for write in after}
    for write in before:
        other, slot = given[write.slot], slots.specs[write.slot]
        if slot.angle < 0 and write.turns != other.turns:
            message = f"drive the same wheels as `actuation` does: {slot.name}"
            problems.add("robot.control", path, message)
        elif write.turns and other.value * write.value < 0:
            message = f"'{slot.name}' turns the other way than under `actuation`"
            problems.add("robot.control", (*path, slot.name), message)
        elif write.turns and write.slot in apexes and not other.turns and other.how != "keep":
            message = f"'{slot.name}' holds its part under `actuation`, here it lets go"
            problems.add("robot.control", (*path, slot.name), message)


class Modifiers(NamedTuple):
    """What a control adds to every state.

    Attributes:
        owner: The control whose ``grip`` it is.
    """

    gravity_compensation: bool = False
    grip: Grip | None = None
    owner: str = ""


def _inherited(control: Control, known: Mapping[str, Modifiers], name: str = "") -> Modifiers:
    """Return what a control adds: its own, else that of the control that it extends."""
    base = known.get(control.extends or "", Modifiers())
    compensates = control.gravity_compensation
    grip, owner = (control.grip, name) if control.grip else (base.grip, base.owner)
    return Modifiers(base.gravity_compensation if compensates is None else compensates, grip, owner)


def _modified(
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


def _assists(signals: Signals) -> dict[int, float]:
    """Return by slot the torque by which each wheel bears its share of the weight, upright."""
    body = signals.profile.body
    share_n = body.mass_kg * GRAVITY_M_S2 / len(body.wheels)
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
            weight_n=body.mass_kg * GRAVITY_M_S2,
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


ByConfiguration = tuple[PostureSpec | None, ...]


@dataclass(frozen=True)
class _Postures:
    """The robot data for resolving postures."""

    table: ChartTable
    signals: Signals
    slots: Slots
    held: tuple[frozenset[int], ...]
    actuation: Actuation

    def pressing(self, configuration: int) -> Iterator[tuple[str, int, float]]:
        """Yield for each held part its name, the slot of its apex, and the duty that holds it."""
        parts = list(self.signals.profile.body.parts.items())
        written = {
            write.slot: write
            for region, state in enumerate(self.table.configurations[configuration])
            for write in self.actuation[region][state][-1]
        }
        for number in sorted(self.held[configuration]):
            name, part = parts[number]
            for slot, each in enumerate(self.signals.profile.slots):
                write = written.get(slot)
                if each.joint == part.apex and write is not None and write.how == "set":
                    yield name, slot, write.value


def resolve_postures(
    table: ChartTable,
    signals: Signals,
    slots: Slots,
    held: tuple[frozenset[int], ...],
    actuation: Actuation,
) -> Mapping[str, ByConfiguration]:
    """Return the postures by name: per configuration the first case that applies, or None.

    A posture moves bend joints only, and keeps the apex of every held part pressed against its
    wall.
    """
    robot = _Postures(table, signals, slots, held, actuation)
    return {name: _posture(robot, name, cases) for name, cases in signals.profile.postures.items()}


def _posture(robot: _Postures, name: str, cases: tuple[PostureCase, ...]) -> ByConfiguration:
    found: list[PostureSpec | None] = [None] * len(robot.table.configurations)
    for number, case in enumerate(cases):
        at: Path = ("postures", name, number)
        spec = _case(robot, name, case, at)
        when = on_states(case.when, robot.table, robot.signals, (*at, "when"))
        said = False
        for configuration, states in enumerate(robot.table.configurations):
            if found[configuration] is not None or not is_true(when, states):
                continue
            found[configuration] = spec
            if not spec.refuse and not said:
                said = _lets_go(robot, spec.writes, configuration, (*at, "set"))
    return tuple(found)


def _case(robot: _Postures, name: str, case: PostureCase, at: Path) -> PostureSpec:
    done = resolve_criterion(case.done, robot.signals, (*at, "done"))
    if case.refuse is not None:
        return PostureSpec(name, (), done, refuse=case.refuse)
    written = case.set_ or {}
    for slot in written:
        each = next((each for each in robot.signals.profile.slots if each.name == slot), None)
        if each is not None and each.joint is None:
            message = f"'{slot}' drives no bend joint, and a posture moves only those"
            robot.signals.problems.add("robot.posture", (*at, "set", slot), message, key=True)
    writes = resolve_stage(written, robot.signals, robot.slots, (*at, "set"))
    within_rad = nan if case.within is None else case.within
    return PostureSpec(name, writes, done, within_rad)


def _lets_go(robot: _Postures, writes: StageSpec, configuration: int, at: Path) -> bool:
    """Return whether the posture releases a part that is held there; report it if so."""
    duties = {write.slot: write.value for write in writes if write.how == "set"}
    written = {write.slot for write in writes}
    for part, slot, duty in robot.pressing(configuration):
        if slot in written and duties.get(slot, 0.0) * duty <= 0:
            name = robot.slots.specs[slot].name
            message = f"'{name}' holds the part '{part}' there: it must keep a duty of that sign"
            robot.signals.problems.add("robot.posture", at, message)
            return True
    return False
