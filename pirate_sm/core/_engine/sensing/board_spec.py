"""What boards report: frames, limits of their sensors, signals of traction, timing of the link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, nan
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.core._model.events import FaultReport
from pirate_sm.core._model.faults import BuiltInFault

if TYPE_CHECKING:  # a model of a file, which the engine does not load
    from pirate_sm.core._model.robot.signals import Operation

# --- limits of sensors ------------------------------------------------------------------------


class WatchSpec(NamedTuple):
    """Limits of a sensor that measures a motor or has limits of its own, in SI units.

    Attributes:
        number: Index of its number.
        name: Name for messages.
        numbers: Indexes of the numbers that depend on it, including its own.
        low: Smallest possible value; ``high``: the largest.
        rate: Fastest change per second but for the unwinding of its spring; ``slack`` is allowed
            in addition.
        moved: Smallest change that counts as motion; infinite if it measures no motion.
        slot: Index of the setpoint of its motor; -1 without one.
        joint: Whether it is the angle of a joint, which cannot restart as a counter can.
        least_duty: Below this duty the motor may stand still although driven.
        load: Index of the current of the same motor; -1 if it is not measured.
        full_load: That current when the motor stalls at full duty.
        torque: Index of the torque of the spring behind the motor; -1 if it is not measured.
        stiffness: Stiffness of that spring, per unit of the angle; ``spring`` is the share by which
            it may differ.
        winds: Torque to which the motor can wind it up.
        unit: Unit for messages; ``per_unit`` is its SI value.
        of: The joint or wheel of the motor.
    """

    number: int
    name: str
    numbers: tuple[int, ...]
    low: float = -inf
    high: float = inf
    rate: float = inf
    slack: float = 0.0
    moved: float = inf
    slot: int = -1
    joint: bool = False
    least_duty: float = inf
    load: int = -1
    full_load: float = 0.0
    torque: int = -1
    stiffness: float = inf
    spring: float = 0.0
    winds: float = inf
    unit: str = ""
    per_unit: float = 1.0
    of: str = ""

    def outside(self, value: float) -> FaultReport:
        """Return the report of a value that keeps outside its range."""
        where = f"{self.low / self.per_unit:.3g} to {self._in_words(self.high)}"
        return self._report(
            BuiltInFault.SENSOR_RANGE, f"reports {self._in_words(value)}, outside {where}"
        )

    def jumped(self, before: float, value: float) -> FaultReport:
        """Return the report of a joint that has jumped."""
        return self._report(
            BuiltInFault.SENSOR_JUMPED,
            f"has jumped from {self._in_words(before)} to {self._in_words(value)}, faster than its "
            "motor can turn: it is unknown until it jumps back",
        )

    def spiking(self, spikes: int, within_s: float) -> FaultReport:
        """Return the report of a sensor that spikes often."""
        return self._report(
            BuiltInFault.SENSOR_SPIKING, f"has spiked {spikes} times in {within_s:.1f} s"
        )

    def stuck(self, after_s: float) -> FaultReport:
        """Return the report of a sensor that shows the same although its motor must turn."""
        return self._report(
            BuiltInFault.SENSOR_STUCK,
            f"has shown the same for {after_s:g} s while its motor is driven and bears no load: "
            "the sensor is stuck, or the motor gets no current",
        )

    def moves(self) -> FaultReport:
        """Return the report of a motion without a setpoint for it."""
        return self._report(
            BuiltInFault.MOTION_UNASKED, "moves though nothing was asked of its motor"
        )

    def _report(self, fault: BuiltInFault, message: str) -> FaultReport:
        return fault.report(f"{self.name} {message}", of=(self.of,) if self.of else ())

    @property
    def can_be(self) -> tuple[BuiltInFault, ...]:
        """Return the faults that this sensor can have, but for silence."""
        has = {
            BuiltInFault.SENSOR_RANGE: self.high < inf,
            BuiltInFault.SENSOR_SPIKING: self.high < inf or self.rate < inf,
            BuiltInFault.SENSOR_JUMPED: self.joint,
            BuiltInFault.SENSOR_STUCK: self.moved < inf and self.load >= 0,
            BuiltInFault.MOTION_UNASKED: self.moved < inf,
        }
        return tuple(fault for fault, can in has.items() if can)

    def _in_words(self, value: float) -> str:
        return f"{value / self.per_unit:.3g} {self.unit}".strip()


@dataclass(frozen=True)
class WatchedSpec:
    """The watched sensors of one board, with lookup tables for every frame."""

    sensors: tuple[WatchSpec, ...] = ()

    @cached_property
    def ranges(self) -> tuple[tuple[int, float, float], ...]:
        """Return number index, smallest and largest value of the sensors with a range."""
        return tuple((w.number, w.low, w.high) for w in self.sensors if w.high < inf)

    @cached_property
    def rates(self) -> tuple[tuple[int, float, float], ...]:
        """Return number index, fastest change per second and slack of the sensors with a rate."""
        return tuple((w.number, w.rate, w.slack) for w in self.sensors if w.rate < inf)

    @cached_property
    def moving(self) -> tuple[int, ...]:
        """Return the places of the sensors that measure a motion."""
        return tuple(place for place, watch in enumerate(self.sensors) if watch.moved < inf)


class PlausibilitySpec(NamedTuple):
    """Thresholds of all sensors; as in ``Plausibility`` of the profile."""

    hold_back: int
    spikes: int
    spikes_within_s: float
    stuck_after_s: float
    unloaded: float
    settle_s: float
    moved_readings: int
    repeats_s: float


# --- frames -----------------------------------------------------------------------------------


class WheelSpec(NamedTuple):
    """A wheel for odometry: its place among the wheels, number indexes of angle and speed, slot.

    Attributes:
        load: Number index of its motor's current; -1 where none is measured.
        n_per_a: Force along its rim per current.
        stall_n: That of its motor at full duty while it stands.
        drag_n: What turns it while its motor does not.
        top_m_s: Speed of its rim at full duty without load.
    """

    place: int
    angle: int
    speed: int
    slot: int
    metres_per_rad: float
    load: int = -1
    n_per_a: float = 0.0
    stall_n: float = 0.0
    drag_n: float = 0.0
    top_m_s: float = inf

    def force_n(self, numbers: Sequence[float]) -> float:
        """Return the force along the rim, without its direction; NaN is unknown."""
        return abs(numbers[self.load]) * self.n_per_a if self.load >= 0 else nan

    def is_pushed(self, numbers: Sequence[float], setpoints: Sequence[float]) -> bool:
        """Return whether it turns faster than its motor would without load."""
        speed_m_s = abs(numbers[self.speed] * self.metres_per_rad)
        return speed_m_s > abs(setpoints[self.slot]) * self.top_m_s


class DerivedSpec(NamedTuple):
    """A number that is derived from others of its board, see :mod:`.evaluator`.

    Attributes:
        how: What does that, or a part of it; its operands come in the order of what follows.
        target: Its index.
        sources: Theirs.
        slot: The slot whose setpoint counts; -1 for none.
        constants: SI.
    """

    how: Operation
    target: int
    sources: tuple[int, ...]
    slot: int = -1
    constants: tuple[float, ...] = ()


def board_name(id_: int) -> str:
    """Return the name by which missions mean a board."""
    return f"board_{id_}"


@dataclass(frozen=True)
class BoardSpec:
    """The content of one board's frame.

    Attributes:
        position: Index among the boards that report.
        channels: (place in the frame, number index, scale to SI).
        derived: The numbers that are derived from these alone.
        wheels: Its wheels.
        faults: Indexes of the fault rules that its signals can change.
        zeros: (number index, reading at the zero position) of each calibrated sensor.
        watched: Its sensors with plausibility limits.
    """

    id: int
    module: str
    position: int
    channels: tuple[tuple[int, int, float], ...]
    derived: tuple[DerivedSpec, ...]
    wheels: tuple[WheelSpec, ...]
    faults: tuple[int, ...]
    zeros: tuple[tuple[int, float], ...] = ()
    watched: WatchedSpec = field(default_factory=WatchedSpec)

    @property
    def name(self) -> str:
        """Return the name by which missions mean the board."""
        return board_name(self.id)

    @cached_property
    def length(self) -> int:
        """Return the smallest number of values in a valid frame."""
        return max((place + 1 for place, *_ in self.channels), default=0)

    @cached_property
    def number_set(self) -> frozenset[int]:
        """Return :attr:`numbers` as a set."""
        return frozenset(self.numbers)

    @property
    def vectors(self) -> tuple[tuple[int, ...], ...]:
        """Return the number indexes of each vector from which a number is derived."""
        made = [each.target for each in self.derived]
        whole = (each for each in self.derived if made.count(each.target) == 1)
        return tuple(each.sources for each in whole if len(each.sources) == 3)

    @property
    def numbers(self) -> tuple[int, ...]:
        """Return the indexes of all numbers that depend on this board only."""
        measured = (target for _, target, _ in self.channels)
        return *measured, *dict.fromkeys(each.target for each in self.derived)


# --- signals of slip, normal force and friction -----------------------------------------------


class WheelTraction(NamedTuple):
    """The signals of one wheel; a number index is -1 where the robot has no such signal.

    Attributes:
        place: Index of the wheel.
        board: Position of the board that reports the wheel.
        slot: Index of its slot.
        speed: Number index of its angular speed.
        torque: Number index of the torque of its motor.
        metres_per_rad: How far ahead it rolls.
        stall_nm: Torque of its motor at full duty when it stands.
        no_load_rad_s: Speed of its motor at full duty without load.
        resists: Force that resists the rolling of its tyre, over its normal force.
        slip_speed: Target, m/s; positive where the rim is faster than the body.
        slip: Target, slip ratio (thesis eq. 2-1).
        normal_force: Target, N.
        friction: Target, coefficient of kinetic friction, estimated online.
        friction_used: Target, force along the wall over normal force.
        unknown_below_m_s: Body speed below which the slip ratio is unknown.
        slip_above_m_s: Slip speed from which on friction is estimated.
        steady_s: For how long it must have slipped.
    """

    place: int
    board: int
    slot: int
    speed: int
    torque: int
    metres_per_rad: float
    stall_nm: float
    no_load_rad_s: float
    resists: float = 0.0
    slip_speed: int = -1
    slip: int = -1
    normal_force: int = -1
    friction: int = -1
    friction_used: int = -1
    unknown_below_m_s: float = 0.0
    slip_above_m_s: float = 0.0
    steady_s: float = 0.0

    @property
    def targets(self) -> tuple[int, ...]:
        """Return the number indexes of the wheel's signals."""
        every = (self.slip_speed, self.slip, self.normal_force, self.friction, self.friction_used)
        return tuple(index for index in every if index >= 0)


class TractionSpec(NamedTuple):
    """What slip, normal force and friction of a robot are made of.

    Attributes:
        wheels: Front to rear.
        board: Position of the board of the last wheel, whose frame ends a round of the boards.
        joint_torques: Per wheel the number index of its joint's torque; -1 without a joint.
        mounts: Per wheel the index of the link that its motor sits on.
        masses_kg: Per wheel its mass, with half of its links.
        measured: Number index of the body speed that somebody outside measures; -1 without one.
        averages_s: How long a time that is a mean over.
        delay_s: By how much a frame may be later than a measurement of the same moment.
        robot_speed: Target, the body speed with its fall-back; -1 without one.
        rolling: The wheels that it falls back to.
        agreeing_m_s: How far the speeds of wheels may differ from their median that agree.
        least: For each target, the numbers that it is the least known one of.
    """

    wheels: tuple[WheelTraction, ...]
    board: int
    joint_torques: tuple[int, ...]
    mounts: tuple[int, ...]
    masses_kg: tuple[float, ...]
    measured: int = -1
    averages_s: float = 0.0
    delay_s: float = 0.0
    robot_speed: int = -1
    rolling: tuple[WheelTraction, ...] = ()
    agreeing_m_s: float = 0.0
    least: tuple[tuple[int, tuple[int, ...]], ...] = ()

    @property
    def targets(self) -> tuple[int, ...]:
        """Return the number indexes of all these signals."""
        shared = [index for index, _ in self.least]
        if self.robot_speed >= 0:
            shared.append(self.robot_speed)
        return (*shared, *(index for wheel in self.wheels for index in wheel.targets))

    def with_motors(
        self, motors: Mapping[int, tuple[float | None, float | None]], resists: float
    ) -> TractionSpec:
        """Return the same with other motors and tyres of the wheels.

        Args:
            motors: Stall torque and speed without load by slot; what is none stays as it is.
            resists: Force that resists the rolling of a tyre, over its normal force.
        """
        given = [(wheel, *motors[wheel.slot]) for wheel in self.wheels]
        return self._replace(
            wheels=tuple(
                wheel._replace(
                    stall_nm=stall or wheel.stall_nm,
                    no_load_rad_s=no_load or wheel.no_load_rad_s,
                    resists=resists,
                )
                for wheel, stall, no_load in given
            )
        )


# --- the link ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class LinkSpec:
    """Timing of the link: report period, and limits for stale signals, silent boards and resends.

    Attributes:
        period_s: The time between two reports of one board. Reports at shorter intervals were
            delayed on their way.
    """

    period_s: float
    stale_after_s: float
    silent_after_s: float
    resend_after_s: float
    resend_limit: int

    @cached_property
    def listen_every_s(self) -> float:
        """Return the interval of the checks for silent boards and stale signals."""
        return min(self.stale_after_s, self.silent_after_s) / 2
