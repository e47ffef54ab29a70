"""A robot as the engine runs it: names resolved to indexes, nothing left to look up by text.

Built by :mod:`pirate_sm.loading.robot` from a profile and its chart, for one polarity. Two tuples
carry all that conditions can see: ``numbers`` (signals, SI, NaN = unknown) and ``words`` (the
state of each region, then the detector's word and the segment, None = unknown).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.engine.robot.chart_table import ChartTable
from pirate_sm.engine.robot.confirmation_spec import Sight
from pirate_sm.engine.robot.criteria import CriterionSpec
from pirate_sm.engine.sensing.body_spec import BodySpec
from pirate_sm.engine.sensing.plausibility_spec import PlausibilitySpec, WatchedSpec
from pirate_sm.expressions import Expression, Vocabulary
from pirate_sm.model.fault_codes import BuiltInFault


class PositionSpec(NamedTuple):
    """A proportional position loop (thesis section 4-2-3): duty = gain * error, then 0."""

    gain: float
    threshold_rad: float
    least_duty: float
    limit: float
    stall_torque_nm: float


class VelocitySpec(NamedTuple):
    """A velocity loop: duty = target / no-load speed, plus an integral of the error.

    Attributes:
        gain: What a fresh frame adds to the integral, as a share of the error.
        limit: Largest duty cycle used.
        no_load_rad_s: Speed of the motor at full duty without load.
        speed: Number index of the wheel's angular speed.
        radius_m: Of the wheel.
    """

    gain: float
    limit: float
    no_load_rad_s: float
    speed: int
    radius_m: float


@dataclass(frozen=True)
class SlotSpec:
    """One setpoint of the wire.

    Attributes:
        angle: Number index of the angle that a position loop or the board's own one controls.
        rate: Number index of that angle's rate; ``torque`` that of the joint's torque; -1 without.
        position: How a duty slot is brought to an angle, None where it cannot be.
        velocity: How a duty slot is kept at a speed, None where it cannot be.
        self_locking: Whether the motor keeps its place at duty 0, whatever the load.
        low: Least value; ``high`` the largest.
        resolution: Steps of the wire.
    """

    name: str
    unit: Literal["duty", "angle"]
    low: float
    high: float
    resolution: float
    angle: int = -1
    rate: int = -1
    torque: int = -1
    position: PositionSpec | None = None
    velocity: VelocitySpec | None = None
    self_locking: bool = False


class Write(NamedTuple):
    """What a stage does to a slot.

    Attributes:
        how: ``set`` a value. ``seek`` an angle by a position loop. ``turn`` at a speed by a
            velocity loop. ``keep`` what is in force: a value, or the loop of another state.
        value: The value, the angle in rad, or the speed in rad/s.
        share_of: Number index of the angle that ``value`` is multiplied by when the stage begins;
            -1 where ``value`` is the angle itself.
    """

    slot: int
    how: Literal["set", "seek", "turn", "keep"]
    value: float
    share_of: int = -1

    @property
    def turns(self) -> bool:
        """Whether it turns a motor, by a duty or a speed other than zero."""
        return self.value != 0 and self.how in ("set", "turn")


StageSpec: TypeAlias = tuple[Write, ...]


@dataclass(frozen=True)
class PostureSpec:
    """What a command brings the joints to before its states' own actuation.

    Attributes:
        name: Of the posture, for people.
        writes: Its setpoints.
        done: What shows, besides every joint at its angle, that it has been reached.
        within_rad: How far a joint may be from its angle; NaN for the threshold of its loop.
        refuse: Why the command is impossible here; empty where it is not.
    """

    name: str
    writes: StageSpec
    done: CriterionSpec
    within_rad: float = nan
    refuse: str = ""


@dataclass(frozen=True)
class CommandSpec:
    """A command beyond the chart.

    Attributes:
        postures: By the configuration that it leads to, the posture that comes first, or None;
            empty for a command that needs none anywhere.
        asks_for: Condition on the states of the regions; where it holds, the command is unneeded.
        asks_parts: Parts that are held wherever it holds; where there are any, their clamps decide
            whether the command is unneeded.
    """

    name: str
    done: CriterionSpec
    timeout_s: float
    nominal_s: float
    lets_go: bool
    postures: tuple[PostureSpec | None, ...] = ()
    asks_for: Expression | None = None
    asks_parts: frozenset[int] = frozenset()

    def posture(self, configuration: int) -> PostureSpec | None:
        """Return the posture that comes first where the command leads to this configuration."""
        return self.postures[configuration] if self.postures else None


@dataclass(frozen=True)
class FaultSpec:
    """A condition on signals that is a fault once it has held.

    Attributes:
        denies: Parts whose clamps it shows not to hold.
    """

    code: str
    message: str
    when: Expression
    held_s: float
    catchable: bool
    denies: frozenset[int] = frozenset()


class WheelSpec(NamedTuple):
    """A wheel for odometry: its place among the wheels, number indexes of angle and speed, slot."""

    place: int
    angle: int
    speed: int
    slot: int
    metres_per_rad: float


class Vector(NamedTuple):
    """A number made of three others: their indexes and the one it goes to."""

    how: Literal["roll", "pitch", "norm"]
    sources: tuple[int, ...]
    target: int


@dataclass(frozen=True)
class BoardSpec:
    """What one board's frame tells.

    Attributes:
        position: Index among the boards that are listened to.
        channels: (place in the frame, number index, scale to SI).
        rates: (number index, index of its rate).
        torques: (number index of the current, slot, scale, number index of the torque).
        vectors: Accelerometer numbers.
        diameters: (number index of the apex angle, link length, 2r, target) of eq. 3-2.
        wheels: Its wheels.
        faults: Indexes of the fault rules that its signals can change.
        zeros: (number index, what its sensor shows when it is zero), where that was calibrated.
        watched: Its sensors whose values have limits.
    """

    id: int
    module: str
    position: int
    channels: tuple[tuple[int, int, float], ...]
    rates: tuple[tuple[int, int], ...]
    torques: tuple[tuple[int, int, float, int], ...]
    vectors: tuple[Vector, ...]
    diameters: tuple[tuple[int, float, float, int], ...]
    wheels: tuple[WheelSpec, ...]
    faults: tuple[int, ...]
    zeros: tuple[tuple[int, float], ...] = ()
    watched: WatchedSpec = field(default_factory=WatchedSpec)

    @cached_property
    def length(self) -> int:
        """Return how many values a frame must have at least."""
        return max((place + 1 for place, *_ in self.channels), default=0)

    @cached_property
    def told(self) -> frozenset[int]:
        """Return :attr:`numbers`, to be asked whether one is among them."""
        return frozenset(self.numbers)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Return the indexes of every number that comes from this board alone."""
        return (
            *(target for _, target, _ in self.channels),
            *(target for _, target in self.rates),
            *(target for *_, target in self.torques),
            *(vector.target for vector in self.vectors),
            *(target for *_, target in self.diameters),
        )


@dataclass(frozen=True)
class LinkSpec:
    """When a signal is stale, a board silent, an array sent again; how often a board reports.

    Attributes:
        period_s: The time between two reports of one board. What comes at shorter intervals has
            waited somewhere.
    """

    period_s: float
    stale_after_s: float
    silent_after_s: float
    resend_after_s: float
    resend_limit: int

    @cached_property
    def listen_every_s(self) -> float:
        """Return how often to look which boards are silent and which signals stale."""
        return min(self.stale_after_s, self.silent_after_s) / 2


@dataclass(frozen=True, eq=False)
class RobotSpec:
    """Everything the engine knows of a robot; no other one is the same.

    Attributes:
        actuation: ``actuation[region][state name]`` is the state's stages.
        held: Per configuration the indexes of the parts that it holds.
        part_regions: Per part the regions that its holding depends on.
        unneeded: Per configuration and command, whether what it asks for is so already.
        safe_zero: Slots that are zero in the safe state.
        sight: How states show themselves before anything moves.
        odometry: Number indexes of odometry and speed; -1 where the robot has none.
        words_behind: Words of the detector that say that the whole robot is beyond the bend.
    """

    name: str
    polarity: Literal["normal", "mirrored"]
    table: ChartTable
    vocabulary: Vocabulary
    slots: tuple[SlotSpec, ...]
    actuation: tuple[Mapping[str, tuple[StageSpec, ...]], ...]
    commands: tuple[CommandSpec, ...]
    parts: tuple[str, ...]
    held: tuple[frozenset[int], ...]
    part_regions: tuple[frozenset[int], ...]
    unneeded: tuple[tuple[bool, ...], ...]
    safe_zero: tuple[int, ...]
    boards: Mapping[int, BoardSpec]
    wheels: tuple[WheelSpec, ...]
    odometry: int
    speed: int
    faults: tuple[FaultSpec, ...]
    link: LinkSpec
    plausibility: PlausibilitySpec
    detector_words: tuple[str, ...]
    words_behind: frozenset[str]
    body: BodySpec
    sight: Sight = field(default_factory=Sight)

    @property
    def regions(self) -> tuple[str, ...]:
        """Return the names of the state machines."""
        return self.table.regions

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

    def denied_by_report(self, code: str, message: str) -> frozenset[int]:
        """Return the parts that a reported fault denies: those of the rule whose words it has."""
        rules = [rule for rule in self.faults if (rule.code, rule.message) == (code, message)]
        return frozenset(part for rule in rules for part in rule.denies)

    def travel(self, values: Sequence[float]) -> int:
        """Return which way setpoints drive the wheels, in this polarity.

        Args:
            values: One per slot.

        Returns:
            1 forward, -1 backward; 0 where no wheel is driven, or wheels against each other.
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
        """Return the slots that the safe state stops and that the state drives."""
        return tuple(
            write.slot
            for write in self.actuation[region][state][-1]
            if write.turns and write.slot in self.safe_zero
        )

    @cached_property
    def fault_codes(self) -> Mapping[str, bool]:
        """Return every fault code of this robot and whether a mission may handle it."""
        known = (*BuiltInFault, *self.faults)
        return {fault.code: fault.catchable for fault in known}
