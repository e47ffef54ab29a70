"""A loaded robot as seen by the rules: moves, writes of states, places; its chart."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.checking.actuation_in_force import Actuated, InForce
from pirate_sm.checking.findings import Finding, Severity, at
from pirate_sm.core.documents import Document, Path, Place
from pirate_sm.core.loading import ChartOutline, LoadedRobot, States, asked_by, holds
from pirate_sm.core.models import Channel, Motor, Profile, Slot
from pirate_sm.core.robot import ChartTable, Need, RobotSpec, StageSpec, Write

if TYPE_CHECKING:
    from pirate_sm.core.robot import ChartTable


class StateWrite(NamedTuple):
    """A write of a state to a slot, with its path in the profile.

    Attributes:
        control: Index of the control that says so; 0 for the usual actuation.
    """

    region: int
    state: str
    stage: int
    write: Write
    path: Path
    control: int = 0


@dataclass(frozen=True)
class RobotView:
    """A loaded robot in normal polarity."""

    loaded: LoadedRobot

    @property
    def profile(self) -> Profile:
        """Return the robot's profile."""
        return self.loaded.profile

    @cached_property
    def slots(self) -> tuple[tuple[Slot, Path], ...]:
        """Return all slots in the order of the wire, with their paths."""
        return tuple(
            (slot, ("boards", number, "slots", place))
            for number, board in enumerate(self.profile.boards)
            for place, slot in enumerate(board.slots)
        )

    @cached_property
    def drives(self) -> dict[str, str]:
        """Return what each slot drives, by their names; empty for one that drives nothing."""
        return {slot.name: slot.drives for slot, _ in self.slots}

    @cached_property
    def slot_of(self) -> dict[str, str]:
        """Return the slot that drives each thing, by their names."""
        return {thing: name for name, thing in self.drives.items()}

    @cached_property
    def channels(self) -> dict[str, tuple[Channel, Path]]:
        """Return the channel of each measured signal, with its path."""
        return {
            channel.signal: (channel, ("boards", number, "channels", place))
            for number, board in enumerate(self.profile.boards)
            for place, channel in enumerate(board.channels)
            if channel.signal
        }

    @cached_property
    def in_force(self) -> InForce:
        """Return what its states write under each control."""
        return InForce(self.profile, self.loaded.normal)

    @cached_property
    def written(self) -> tuple[StateWrite, ...]:
        """Return all writes of all states, those of each control after the usual ones."""
        robot = self.loaded.normal
        found: list[StateWrite] = []
        for control, spec in enumerate(robot.controls):
            own = self.profile.controls[spec.name].actuation if control else None
            at: Path = ("controls", spec.name, "actuation") if control else ("actuation",)
            for region, states in enumerate(spec.actuation):
                name = robot.regions[region]
                for state, stages in states.items():
                    if own is None or state in own.get(name, {}):
                        found += _written(robot, (*at, name, state), region, state, stages, control)
        return tuple(found)

    def motor(self, slot: int) -> Motor:
        """Return the motor of a slot."""
        return self.profile.motors[self.profile.slots[slot].motor]

    def moves(self, command: int) -> Iterator[tuple[int, int]]:
        """Yield each configuration that the command changes, with the one that follows."""
        for before, row in enumerate(self.loaded.table.following):
            if row[command] != before:
                yield before, row[command]

    def led(self, command: int, control: int = 0) -> list[Actuated]:
        """Return where a command leads to, under a control."""
        return [Actuated(after, control) for _, after in self.moves(command)]

    @cached_property
    def heard(self) -> frozenset[int]:
        """Return the indexes of numbers that fitted boards report, and those derived from them."""
        robot = self.loaded.normal
        told = {index for board in robot.boards.values() for index in board.numbers}
        told |= {index for index, _ in robot.outside.values()}
        told |= set(robot.traction.targets if robot.traction else ())
        return frozenset(told | {robot.odometry, robot.speed})

    def unmeasured(self, signals: Iterable[int]) -> str:
        """Return which of these signals no board measures, as a reason; empty if all are."""
        missing = next((each for each in signals if each >= 0 and each not in self.heard), -1)
        names = self.loaded.normal.vocabulary.numbers
        return f"no fitted board measures {names[missing]}" if missing >= 0 else ""

    def unheard(self, needs: Iterable[Need]) -> str:
        """Return which signal is missing without which one of these is never true."""
        return self.unmeasured(at for need in needs for at in need.unheard(self.heard))

    def configurations(self, regions: Set[str]) -> list[tuple[str, ...]]:
        """Return one reached configuration for each combination of the states of these regions."""
        table = self.loaded.table
        places = [number for number, name in enumerate(table.regions) if name in regions]
        found = {tuple(row[place] for place in places): row for row in table.configurations}
        return list(found.values())

    def at(
        self,
        path: Path,
        code: str,
        message: str,
        *,
        key: bool = False,
        offset: int | None = None,
        fix: str = "",
        severity: Severity | None = None,
    ) -> Finding:
        """Return a finding at a value, or a key, of the profile."""
        document = self.loaded.documents[0]
        place = document.place_of(path, key=key, offset=offset)
        return at(document, place, code, message, fix=fix, severity=severity)


def _written(
    robot: RobotSpec, at: Path, region: int, state: str, stages: tuple[StageSpec, ...], control: int
) -> Iterator[StateWrite]:
    """Yield what the stages of one state write; ``at`` is the path of the state."""
    for number, stage in enumerate(stages):
        path = (*at, number) if len(stages) > 1 else at
        for write in stage:
            here = (*path, robot.slots[write.slot].name)
            yield StateWrite(region, state, number, write, here, control)


# --- its chart: guards ----------------------------------------------------------------------------
# A guard consists of `In('Region.State')`, and, or, not (the loader refuses anything else), so it
# depends on the states of the regions that it names. Every combination of states is *thinkable*;
# the combinations that commands lead to are *reached*.


MOST_COMBINATIONS = 4096
"""With more thinkable combinations a guard counts as not constant."""

_ELSEWHERE = ""


def offset_of(guard: str, node: ast.expr) -> int:
    """Return the offset of a part of a guard in the guard's text."""
    lines = guard.split("\n")
    before = sum(len(line) + 1 for line in lines[: node.lineno - 1])
    return before + len(lines[node.lineno - 1].encode()[: node.col_offset].decode())


def regions_of(node: ast.expr) -> frozenset[str]:
    """Return the regions that a part of a guard names."""
    return frozenset(region for region, _ in _questions(node))


def constant(
    node: ast.expr, states: Mapping[str, Iterable[str]], fixed: States | None = None
) -> bool | None:
    """Return the constant value of a part of a guard in all thinkable combinations, or None.

    Args:
        node: The part.
        states: The states of each region.
        fixed: Regions whose state is known.
    """
    named: dict[str, set[str]] = {}
    for region, asked in _questions(node):
        named.setdefault(region, set()).update(asked)
    choices = []
    for region, mentioned in named.items():
        if fixed and region in fixed:
            choices.append([fixed[region]])
        else:
            # All states that it does not name are equivalent.
            others = [_ELSEWHERE] if set(states[region]) - mentioned else []
            choices.append([*sorted(mentioned), *others])
    if prod(map(len, choices)) > MOST_COMBINATIONS:
        return None
    found = {holds(node, dict(zip(named, each, strict=True))) for each in product(*choices)}
    return found.pop() if len(found) == 1 else None


def constant_parts(
    node: ast.expr, states: Mapping[str, Iterable[str]]
) -> Iterator[tuple[ast.expr, bool]]:
    """Yield the largest parts that are constant in all thinkable combinations, with the value."""
    value = constant(node, states)
    if value is not None:
        yield node, value
    elif isinstance(node, ast.BoolOp):
        for part in node.values:
            yield from constant_parts(part, states)
    elif isinstance(node, ast.UnaryOp):
        yield from constant_parts(node.operand, states)


class ReachedCombinations:
    """The reached combinations, projected on a few regions at a time."""

    def __init__(self, table: ChartTable) -> None:
        self._table = table
        self._seen: dict[frozenset[str], list[dict[str, str]]] = {}

    def through(self, regions: frozenset[str]) -> list[dict[str, str]]:
        """Return the distinct reached combinations of the states of these regions."""
        if regions not in self._seen:
            places = [number for number, name in enumerate(self._table.regions) if name in regions]
            names = [self._table.regions[place] for place in places]
            rows = {tuple(row[p] for p in places): None for row in self._table.configurations}
            self._seen[regions] = [dict(zip(names, row, strict=True)) for row in rows]
        return self._seen[regions]


def _questions(node: ast.expr) -> Iterator[tuple[str, list[str]]]:
    for each in ast.walk(node):
        if isinstance(each, ast.Call):
            yield asked_by(each)


# --- its chart: the view --------------------------------------------------------------------------


@dataclass(frozen=True)
class ChartView:
    """A chart that is being checked."""

    document: Document
    outline: ChartOutline
    table: ChartTable

    @cached_property
    def reached(self) -> ReachedCombinations:
        """Return the combinations of states that commands reach."""
        return ReachedCombinations(self.table)

    @cached_property
    def states(self) -> dict[str, tuple[str, ...]]:
        """Return the states of each region."""
        return dict(zip(self.outline.regions, self.outline.states, strict=True))

    def at(
        self, place: Place, code: str, message: str, *, related: Sequence[tuple[Place, str]] = ()
    ) -> Finding:
        """Return a finding at a place of the chart's file."""
        return at(self.document, place, code, message, related=related)
