"""Resolve the postures of commands for each configuration to which the commands lead."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import nan

from pirate_sm.core._engine.robot.command_spec import PostureSpec, StageSpec
from pirate_sm.core._engine.robot.criteria import AcceptedSpec, CriterionSpec
from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._loading.problems import Path
from pirate_sm.core._loading.robot.actuation import resolve_stage
from pirate_sm.core._loading.robot.commands import is_true, on_states, resolve_criterion
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._loading.robot.slots import Slots
from pirate_sm.core._model.actuation import PostureCase

ByConfiguration = tuple[PostureSpec | None, ...]


@dataclass(frozen=True)
class _Robot:
    """The robot data for resolving postures."""

    table: ChartTable
    signals: Signals
    slots: Slots
    held: tuple[frozenset[int], ...]
    actuation: tuple[Mapping[str, tuple[StageSpec, ...]], ...]

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
    actuation: tuple[Mapping[str, tuple[StageSpec, ...]], ...],
) -> Mapping[str, ByConfiguration]:
    """Return the postures by name: per configuration the first case that applies, or None.

    A posture moves bend joints only, and keeps the apex of every held part pressed against its
    wall.
    """
    robot = _Robot(table, signals, slots, held, actuation)
    return {name: _posture(robot, name, cases) for name, cases in signals.profile.postures.items()}


def _posture(robot: _Robot, name: str, cases: tuple[PostureCase, ...]) -> ByConfiguration:
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


def _case(robot: _Robot, name: str, case: PostureCase, at: Path) -> PostureSpec:
    if case.refuse is not None:
        return PostureSpec(name, (), AcceptedSpec(), refuse=case.refuse)
    written = case.set_ or {}
    for slot in written:
        each = next((each for each in robot.signals.profile.slots if each.name == slot), None)
        if each is not None and each.joint is None:
            message = f"'{slot}' drives no bend joint, and a posture moves only those"
            robot.signals.problems.add("robot.posture", (*at, "set", slot), message, key=True)
    writes = resolve_stage(written, robot.signals, robot.slots, (*at, "set"))
    within_rad = nan if case.within is None else case.within
    done: CriterionSpec = AcceptedSpec()
    if case.done is not None:
        path: Path = (*at, "done")
        done = resolve_criterion(case.done, robot.signals, path)
    return PostureSpec(name, writes, done, within_rad)


def _lets_go(robot: _Robot, writes: StageSpec, configuration: int, at: Path) -> bool:
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
