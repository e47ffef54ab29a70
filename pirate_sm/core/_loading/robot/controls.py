"""Resolve the controls of a robot: overlays of its actuation."""

from __future__ import annotations

from pirate_sm.core._engine.robot.command_spec import StageSpec
from pirate_sm.core._engine.robot.robot_spec import USUAL, Actuation, ChartTable, ControlSpec
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.actuation import resolve_stage
from pirate_sm.core._loading.robot.control_modifiers import Modifiers, inherited, modified
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._loading.robot.slots import Slots
from pirate_sm.core._model.actuation import Level, Share, Target
from pirate_sm.core._model.control import Control


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
                _check(usual[place][state], tuple(resolved), slots, apexes, path, problems)
                overlaid[place][state] = tuple(resolved)
        found[name] = tuple(overlaid)
        modifiers[name] = inherited(control, modifiers, name)
        specs.append(
            ControlSpec(name, modified(found[name], name, modifiers[name], signals, slots))
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


def _check(
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
