"""The robot as the engine uses it, with all names resolved to indexes, and its chart as a table.

:mod:`pirate_sm.core._loading.robot` builds it from a profile and its chart, for one polarity.
Conditions see two tuples: ``numbers`` (signals in SI units, NaN = unknown) and ``words`` (the state
of each region, then the detector's word, the segment and the joint, None = unknown). The statechart
library defines the semantics of the chart: :mod:`pirate_sm.core._loading.chart_exploration`
explores it with that and builds the table. The engine only looks transitions up.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from typing import Literal, TypeAlias

from pirate_sm.core._engine.robot.actuation_spec import SlotSpec, StageSpec
from pirate_sm.core._engine.robot.criteria import CriterionSpec, Sight
from pirate_sm.core._engine.sensing.board_spec import (
    BoardSpec,
    LinkSpec,
    PlausibilitySpec,
    TractionSpec,
    WheelSpec,
)
from pirate_sm.core._engine.sensing.body_spec import BodySpec
from pirate_sm.core._expressions import Expression, Vocabulary
from pirate_sm.core._model.events import FaultReport
from pirate_sm.core._model.faults import BuiltInFault

Configuration = tuple[str, ...]


@dataclass(frozen=True)
class ChartTable:
    """Every reachable configuration, and for each command the configuration that follows.

    Attributes:
        regions: Names of the parallel state machines.
        states: Per region the names of its states.
        commands: Names of the events.
        configurations: Every reachable combination, one state name per region.
        following: ``following[configuration][command]`` is an index into ``configurations``; the
            same index means that the chart does not move.
        refusals: ``refusals[configuration][command]`` is an index into ``reasons``; it says why
            the chart does not move.
        reasons: The distinct reasons; the first is empty.
    """

    regions: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    commands: tuple[str, ...]
    configurations: tuple[Configuration, ...]
    following: tuple[tuple[int, ...], ...]
    refusals: tuple[tuple[int, ...], ...]
    reasons: tuple[str, ...]
    initial: int = 0
    _index: dict[Configuration, int] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        index = {states: number for number, states in enumerate(self.configurations)}
        object.__setattr__(self, "_index", index)

    @cached_property
    def command_index(self) -> Mapping[str, int]:
        """Return the index of each command by its name."""
        return {name: number for number, name in enumerate(self.commands)}

    def index_of(self, configuration: Configuration) -> int | None:
        """Return the index of a configuration, or None when it cannot be reached."""
        return self._index.get(configuration)

    def follow(self, configuration: int, command: int) -> int:
        """Return the configuration that the chart has after the command."""
        return self.following[configuration][command]

    def why_not(self, configuration: int, command: int) -> str:
        """Return why the chart does not move: the unmet conditions of the command."""
        return self.reasons[self.refusals[configuration][command]]


@dataclass(frozen=True)
class FaultSpec:
    """A condition on signals that is a fault once it has held for a time.

    Attributes:
        denies: Parts whose clamps do not hold while the condition is true.
        of: Names that it is a fault of, see :class:`Owners`.
    """

    code: str
    message: str
    when: Expression
    held_s: float
    catchable: bool
    denies: frozenset[int] = frozenset()
    of: tuple[str, ...] = ()


@dataclass(frozen=True)
class Owners:
    """Whose a fault can be.

    Attributes:
        things: Of each board, joint, wheel and part, by name, what a fault of it concerns: joints,
            wheels, and boards with sensors of neither.
        measured: The joint, wheel or board that each measured number belongs to, by its index.
    """

    things: Mapping[str, frozenset[str]] = field(default_factory=dict)
    measured: Mapping[int, str] = field(default_factory=dict)

    def things_of(self, names: Iterable[str]) -> frozenset[str]:
        """Return what faults of all these names concern; an unknown name concerns nothing."""
        return frozenset[str]().union(*(self.things.get(name, ()) for name in names))


@dataclass(frozen=True)
class WordCondition:
    """A detector's word, and the condition on signals that must have held for a time."""

    word: str
    when: Expression
    held_s: float


USUAL = "none"
"""The name by which a mission takes the robot's usual actuation."""


Actuation: TypeAlias = tuple[Mapping[str, tuple[StageSpec, ...]], ...]
"""Per region, the stages of each of its states."""


@dataclass(frozen=True)
class ControlSpec:
    """A way to actuate the robot's states.

    Attributes:
        name: Empty for the usual one.
    """

    name: str
    actuation: Actuation


@dataclass(frozen=True)
class PostureSpec:
    """A posture: joint angles that a command reaches before the actuation of its states.

    Attributes:
        name: Name of the posture, for messages.
        writes: Its setpoints.
        done: Criterion of completion, besides every joint at its angle.
        within_rad: Tolerance of the angles; NaN for the threshold of the position loop.
        refuse: Why the command is impossible here; empty if it is possible.
    """

    name: str
    writes: StageSpec
    done: CriterionSpec
    within_rad: float = nan
    refuse: str = ""


@dataclass(frozen=True)
class CommandSpec:
    """The properties of a command that the chart does not define.

    Attributes:
        postures: The posture for each target configuration, or None; empty for a command without
            postures.
        asks_for: Condition on the states of the regions. Where it holds, the command is unneeded.
        asks_parts: Parts that are held wherever ``asks_for`` holds. If there are any, the command
            is unneeded only while their clamps are confirmed.
    """

    name: str
    done: CriterionSpec
    timeout_s: float
    nominal_s: float
    lets_go: bool
    postures: tuple[PostureSpec | None, ...] = ()
    asks_for: Expression | None = None
    asks_parts: frozenset[int] = frozenset()

    @property
    def proof(self) -> Literal["sensor", "echo"]:
        """Return what it takes to show that the command is done."""
        return "echo" if self.done.kind == "accepted" else "sensor"

    def posture(self, configuration: int) -> PostureSpec | None:
        """Return the posture that precedes a change to this configuration, or None."""
        return self.postures[configuration] if self.postures else None


@dataclass(frozen=True, eq=False)
class RobotSpec:
    """Everything the engine knows about a robot; compared by identity.

    Attributes:
        actuation: ``actuation[region][state name]`` is the state's stages under the usual control.
        overlays: Other ways to actuate the states, see :attr:`controls`.
        traction: Its signals of slip, normal force and friction; None where it has none.
        outside: Of each signal that is measured outside, its number index and how long it counts.
        held: Per configuration the indexes of the parts that it holds.
        part_regions: Per part the regions that its holding depends on.
        unneeded: Per configuration and command, whether what it asks for is so already.
        safe_zero: Slots that are zero in the safe state.
        sight: Criteria of the start check.
        odometry: Number indexes of odometry, its bound and speed; -1 where the robot has none.
        words_behind: Words of the detector that mean that the whole robot has passed the bend.
        words_joint: The kind of joint that a word of the detector announces, for those that do.
        owners: The boards, joints, wheels and parts that a fault can be of.
        word_conditions: Words of the detector that have a condition on signals, as they follow
            each other.
    """

    name: str
    polarity: Literal["normal", "mirrored"]
    table: ChartTable
    vocabulary: Vocabulary
    slots: tuple[SlotSpec, ...]
    actuation: Actuation
    commands: tuple[CommandSpec, ...]
    parts: tuple[str, ...]
    held: tuple[frozenset[int], ...]
    part_regions: tuple[frozenset[int], ...]
    unneeded: tuple[tuple[bool, ...], ...]
    safe_zero: tuple[int, ...]
    boards: Mapping[int, BoardSpec]
    wheels: tuple[WheelSpec, ...]
    odometry: int
    bound: int
    speed: int
    faults: tuple[FaultSpec, ...]
    link: LinkSpec
    plausibility: PlausibilitySpec
    detector_words: tuple[str, ...]
    words_behind: frozenset[str]
    body: BodySpec
    sight: Sight = field(default_factory=Sight)
    overlays: tuple[ControlSpec, ...] = ()
    traction: TractionSpec | None = None
    outside: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    word_conditions: tuple[WordCondition, ...] = ()
    words_joint: Mapping[str, str] = field(default_factory=dict)
    owners: Owners = field(default_factory=Owners)

    @property
    def regions(self) -> tuple[str, ...]:
        """Return the names of the state machines."""
        return self.table.regions

    @cached_property
    def controls(self) -> tuple[ControlSpec, ...]:
        """Return the ways to actuate the states; the first is the usual one."""
        return (ControlSpec("", self.actuation), *self.overlays)

    def control_name(self, control: int) -> str:
        """Return the name of a control, given by its index, as missions write it."""
        return self.controls[control].name or USUAL

    @cached_property
    def estimated(self) -> frozenset[str]:
        """Return the names of the signals of slip, normal force and friction."""
        targets = () if self.traction is None else self.traction.targets
        return frozenset(self.vocabulary.numbers[index] for index in targets)

    @cached_property
    def wheel_boards(self) -> tuple[int, ...]:
        """Return the position of the board that reports each wheel; -1 where none does."""
        positions = {
            wheel.place: board.position for board in self.boards.values() for wheel in board.wheels
        }
        return tuple(positions.get(wheel.place, -1) for wheel in self.wheels)

    def denied_by(self, faults: frozenset[int]) -> dict[int, str]:
        """Return the parts whose clamps these fault rules, given by index, show not to hold.

        Each comes with the words of the rule.
        """
        if not faults:
            return {}
        rules = [self.faults[index] for index in sorted(faults)]
        return {part: rule.message for rule in rules for part in rule.denies}

    def rule_of(self, report: FaultReport) -> FaultSpec | None:
        """Return the fault rule with the code and the message of a report; None without one."""
        rules = (each for each in self.faults if each.code == report.code)
        return next((rule for rule in rules if rule.message == report.message), None)

    def denied_by_report(self, report: FaultReport) -> frozenset[int]:
        """Return the parts whose clamps a report denies: those of its rule."""
        rule = self.rule_of(report)
        return rule.denies if rule else frozenset()

    def unproved(self, names: Iterable[str]) -> frozenset[int]:
        """Return the parts of which no sensor shows that they hold while these are not measured."""
        lost = self.owners.things_of(names)
        return frozenset(part for part, needs in enumerate(self.proofs) if needs & lost)

    @cached_property
    def proofs(self) -> tuple[frozenset[str], ...]:
        """Return per part the joints whose sensors show that it holds."""
        measured = self.owners.measured
        return tuple(
            frozenset(measured[n] for n in (s.apex, *(j.torque for j in s.joints)) if n in measured)
            if s is not None
            else frozenset()
            for s in self.sight.parts
        )

    def travel(self, values: Sequence[float]) -> int:
        """Return the direction in which the setpoints drive the robot, in this polarity.

        Args:
            values: One per slot.

        Returns:
            1 forward, -1 backward; 0 if no wheel is driven or wheels oppose each other.
        """
        ways = {
            1 if values[wheel.slot] * wheel.metres_per_rad > 0 else -1
            for wheel in self.wheels
            if values[wheel.slot]
        }
        return ways.pop() if len(ways) == 1 else 0

    @cached_property
    def driven(self) -> tuple[Mapping[int, tuple[int, ...]], ...]:
        """Return per configuration the regions that drive wheels, each with the wheels' slots."""
        return tuple(
            {
                region: slots
                for region, name in enumerate(states)
                if (slots := self._wheels(region, name))
            }
            for states in self.table.configurations
        )

    def _wheels(self, region: int, state: str) -> tuple[int, ...]:
        """Return the wheel slots that the state drives; the safe state stops all of them."""
        return tuple(
            write.slot
            for write in self.actuation[region][state][-1]
            if write.turns and write.slot in self.safe_zero
        )

    @cached_property
    def possible_owners(self) -> Mapping[str, frozenset[str]]:
        """Return the joints, wheels and boards that each fault can be of; nobody where it has none.

        See :attr:`Owners.things`.
        """
        owners, found = self.owners, defaultdict[str, frozenset[str]](frozenset)
        found[BuiltInFault.SENSOR_SILENT.code] = owners.things_of(owners.things)
        for watch in (each for board in self.boards.values() for each in board.watched.sensors):
            for fault in watch.can_be:
                found[fault.code] |= {watch.of} - {""}
        for slot in self.slots:
            if slot.held_torque is not None:
                found[BuiltInFault.GRIP_EXHAUSTED.code] |= {slot.drives}
        for rule in self.faults:
            found[rule.code] |= owners.things_of(rule.of)
        return found

    @cached_property
    def fault_codes(self) -> Mapping[str, bool]:
        """Return every fault code of this robot and whether a mission may handle it."""
        known = (*BuiltInFault, *self.faults)
        return {fault.code: fault.catchable for fault in known}
