"""A robot as its folder describes it; everything the engine and the backends know of a robot.

The models mirror ``profile.yaml`` key by key. What refers to what (a slot to a joint, a command
to the chart) is checked in :mod:`pirate_sm.loading.robot`, where every fault has a place.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BeforeValidator, Field, model_validator

from pirate_sm.model.actuation import PostureCase, Stage
from pirate_sm.model.base import (
    AlsoWritten,
    Condition,
    FaultCode,
    Format,
    Frozen,
    Name,
)
from pirate_sm.model.body import Body
from pirate_sm.model.criteria import Criterion
from pirate_sm.model.derived import Conversion, Derived
from pirate_sm.model.plausibility import Plausibility
from pirate_sm.model.quantities import (
    Angle,
    AngularSpeed,
    Count,
    Current,
    Duration,
    Flag,
    Inertia,
    Length,
    Number,
    Ratio,
    Stiffness,
    Torque,
)
from pirate_sm.model.safety import SafetyRule
from pirate_sm.model.seen import Seen
from pirate_sm.model.serial_link import Serial
from pirate_sm.model.simulation import Simulation

PositiveDuration = Annotated[Duration, Field(gt=0)]


class PositionLoop(Frozen):
    """A proportional position controller that ends at duty 0 inside its threshold (alg. 3).

    Attributes:
        gain: Duty cycle per rad of error.
        threshold: Error inside which the joint has arrived.
        least_duty: Duty cycle below which the motor would stand still.
        limit: Largest duty cycle used.
    """

    gain: Annotated[Number, Field(gt=0)]
    threshold: Annotated[Angle, Field(gt=0)]
    least_duty: Annotated[Ratio, Field(ge=0, le=1)] = 0.0
    limit: Annotated[Ratio, Field(gt=0, le=1)] = 1.0


class VelocityLoop(Frozen):
    """A controller that keeps a wheel at a speed, by its no-load speed and an integral.

    Attributes:
        gain: What a fresh frame corrects, as a share of the error.
        limit: Largest duty cycle used.
    """

    gain: Annotated[Number, Field(gt=0, le=1)]
    limit: Annotated[Ratio, Field(gt=0, le=1)] = 1.0


class Motor(Frozen):
    """A kind of motor with what limits it; what a kind needs is checked at loading.

    Attributes:
        kind: ``sprung_worm``: self-locking, behind a series spring. ``geared``: a wheel.
            ``position``: takes an angle, the board controls it. ``light``. ``none``.
        stall_torque: Torque at full duty when it stands.
        stall_current: Current at full duty when it stands.
        no_load_speed: Speed at full duty without load.
        hold_torque: Torque that turns a geared motor against its gearbox at duty 0.
        dead_drag: Torque with which a geared motor drags that has failed.
        rotor_inertia: Moment of inertia of a geared motor's rotor, seen at the wheel: its own times
            the squared ratio of the gear.
        stiffness: Of the series spring.
        position_loop: How a duty slot is brought to an angle.
        velocity_loop: How a wheel is kept at a speed; needs ``no_load_speed``.
    """

    kind: Literal["sprung_worm", "geared", "position", "light", "none"]
    stall_torque: Torque | None = None
    stall_current: Current | None = None
    no_load_speed: AngularSpeed | None = None
    hold_torque: Torque | None = None
    dead_drag: Torque | None = None
    rotor_inertia: Inertia | None = None
    stiffness: Stiffness | None = None
    position_loop: PositionLoop | None = None
    velocity_loop: VelocityLoop | None = None

    @model_validator(mode="after")
    def _knows_its_speed(self) -> Motor:
        if self.velocity_loop is not None and not self.no_load_speed:
            raise ValueError("a `velocity_loop` needs the `no_load_speed` of the motor")
        return self


class Slot(Frozen):
    """One setpoint of the wire and what it drives.

    Attributes:
        name: Name of the slot.
        unit: ``duty``: -1..1 of full voltage. ``angle``: rad, the board has its own controller.
        motor: The kind of motor behind it.
        joint: The joint that it drives.
        wheel: The wheel that it drives.
        roll: The signal of the roll joint that it drives.
        mirrors: Whether the setpoint changes sign in mirrored polarity.
        limit: Largest magnitude of an angle setpoint.
    """

    name: Name
    unit: Literal["duty", "angle"]
    motor: Name
    joint: Name | None = None
    wheel: Name | None = None
    roll: Name | None = None
    mirrors: Flag = False
    limit: Angle | None = None


SlotSense: TypeAlias = Literal["angle", "torque", "current", "turned"]
"""What is measured of a slot's joint, wheel or roll joint; all else is measured of the body."""

Sense: TypeAlias = Literal[SlotSense, "acc_x", "acc_y", "acc_z", "mag_x", "mag_y", "mag_z"]


class Channel(Frozen):
    """One raw value of a board; without a signal it is carried but not interpreted.

    Attributes:
        name: Name of the channel.
        signal: Name under which conditions know it.
        convert: Conversion from raw to SI.
        senses: What it measures, so that a simulator can make it. ``turned`` is a mean of
            differences of an angle (thesis B-11).
        slot: The slot whose joint, wheel or roll is measured.
    """

    name: Name
    signal: Name | None = None
    convert: Name | None = None
    senses: Sense | None = None
    slot: Name | None = None


class Board(Frozen):
    """A board on the bus: its motor slots and its channels in the order of the wire.

    Attributes:
        id: Address on the bus.
        module: The module that it sits in.
        fitted: ``false`` for what is not there; its place on the wire stays.
        channels_fitted: ``false`` where its sensors are not there; their place on the wire stays.
        slots: Setpoints in the order of the wire.
        channels: Raw values in the order of the wire.
    """

    id: Count
    module: Name
    fitted: Flag = True
    channels_fitted: Flag = True
    slots: tuple[Slot, ...]
    channels: tuple[Channel, ...] = ()


class LinkSettings(Frozen):
    """Timing and resolution of the wire between us and the boards.

    Attributes:
        cycle: One state message comes per cycle.
        state_message: ``board``: one message per board. ``value``: one per value.
        echo_delay: Until a setpoint array is confirmed.
        duty_resolution: Step of a duty cycle on the wire.
        angle_resolution: Step of an angle on the wire.
        stale_after: A signal not heard for this long is unknown.
        silent_after: A board not heard for this long is a fault, all of them are a lost link.
        resend_after: An array of unknown fate is sent again after this long.
        resend_limit: How often an array of unknown fate is sent again.
    """

    cycle: PositiveDuration
    state_message: Literal["board", "value"] = "board"
    echo_delay: Annotated[Duration, Field(ge=0)] = 0.0
    duty_resolution: Annotated[Ratio, Field(gt=0)]
    angle_resolution: Annotated[Angle, Field(gt=0)]
    stale_after: PositiveDuration
    silent_after: PositiveDuration
    resend_after: PositiveDuration
    resend_limit: Count


def _one_stage_is_a_list(value: Any) -> Any:
    return [value] if isinstance(value, dict) else value


Stages = Annotated[
    tuple[Stage, ...],
    BeforeValidator(_one_stage_is_a_list),
    Field(min_length=1),
    AlsoWritten(lambda usual: [usual["items"]]),
]


class Command(Frozen):
    """A command's meaning beyond the chart.

    Attributes:
        asks_for: Condition on states; where it holds already the command is unneeded.
        done: What shows that it has happened.
        timeout: From acceptance; after it the command has failed.
        nominal: How long it takes on paper, for backends in which nothing moves.
        lets_go: Whether it may open the last confirmed clamp.
        posture: The posture that the robot takes first, before the states' own actuation.
        description: One line for people.
    """

    asks_for: Condition
    done: Criterion
    timeout: PositiveDuration
    nominal: PositiveDuration
    lets_go: Flag = False
    posture: Name | None = None
    description: str = ""


class SafeState(Frozen):
    """Slots that the safe state sets to zero; every other keeps its last accepted value.

    Attributes:
        zero: Slots that go to zero; all others keep their last accepted value.
    """

    zero: Annotated[tuple[Name, ...], Field(min_length=1)]


class FaultRule(Frozen):
    """A fault that the signals tell: a condition that has held for a time.

    Attributes:
        code: The fault's code, ``family.detail``.
        when: The condition; ``{i}`` stands for each of ``for_each``, ``$JOINT_stop`` for the end
            stop of a joint.
        held: How long it must have been true without a break.
        message: What people read.
        catchable: ``false`` for what no mission may handle.
        for_each: The rule is written out for each of these numbers, in place of ``{i}``.
        denies: Parts whose clamps it shows not to hold: as long as it is true they are not
            confirmed, whatever a command's criterion says.
    """

    code: FaultCode
    when: Condition
    held: Annotated[Duration, Field(ge=0)]
    message: str
    catchable: Flag = True
    for_each: tuple[Count, ...] = ()
    denies: tuple[Name, ...] = ()


class DetectorPoint(Frozen):
    """A wheel and how far beyond the crossing of the pipe axes it is, along the pipe.

    Attributes:
        wheel: The wheel.
        passed: How far it has passed the crossing of the pipe's axes; negative: still before it.
    """

    wheel: Name
    passed: Length


class DetectorDefinition(Frozen):
    """Where a detector's word begins to hold, for either direction of travel.

    Attributes:
        forward: Where it begins when driving forward.
        backward: Where it begins when driving backward.
    """

    forward: DetectorPoint
    backward: DetectorPoint


class Detector(Frozen):
    """The words a detector may say; a word is a level that is valid for a time.

    Attributes:
        valid_for: How long a word holds unless another is said.
        words: The words, and where each begins to hold.
    """

    valid_for: PositiveDuration
    words: Annotated[dict[Name, DetectorDefinition], Field(min_length=1)]


class Profile(Frozen):
    """A whole robot.

    Attributes:
        format: Version of this format.
        robot: Name of the robot.
        description: One line for people.
        chart: The chart's file, beside this one.
        body: The planar chain of wheels and links.
        motors: Kinds of motors by name; slots refer to them.
        boards: The boards in the order of the wire.
        link: Timing and resolution of the wire.
        plausibility: Limits beyond which a sensor is wrong.
        conversions: Scales from raw counts to SI, by name.
        derived: Signals that are computed from others, by name.
        actuation: For each region and each of its states, what the slots get.
        postures: What commands bring the joints to first, by name. Of each posture the first
            case counts whose condition holds; where none holds, the command needs no posture.
        commands: One entry for each event of the chart.
        aliases: Other names of commands: ``{other: command}``.
        not_commands: Names that people may try, each with what to say then.
        seen: How states show themselves to the sensors before anything moves.
        safe_state: What makes the robot safe.
        faults: Faults that the signals tell.
        rules: Safety rules: missions are checked against them, and watched in every run.
        detector: The words of a detector.
        simulation: What only the simulator reads.
        serial: The serial link; none for a robot that is only simulated.
    """

    format: Format
    robot: Name
    description: str
    chart: str
    body: Body
    motors: dict[Name, Motor]
    boards: Annotated[tuple[Board, ...], Field(min_length=1)]
    link: LinkSettings
    plausibility: Plausibility = Plausibility()
    conversions: dict[Name, Conversion]
    derived: dict[Name, Derived]
    actuation: dict[Name, dict[Name, Stages]]
    postures: dict[Name, Annotated[tuple[PostureCase, ...], Field(min_length=1)]] = {}
    commands: dict[Name, Command]
    aliases: dict[Name, Name] = {}
    not_commands: dict[Name, str] = {}
    seen: Seen = Seen()
    safe_state: SafeState
    faults: tuple[FaultRule, ...] = ()
    rules: tuple[SafetyRule, ...] = ()
    detector: Detector
    simulation: Simulation
    serial: Serial | None = None

    @property
    def slots(self) -> tuple[Slot, ...]:
        """Return all slots in the order of the wire."""
        return tuple(slot for board in self.boards for slot in board.slots)

    @property
    def heard(self) -> tuple[Board, ...]:
        """Return the boards that report, in the order in which they do."""
        return tuple(b for b in self.boards if b.fitted and b.channels_fitted and b.channels)

    @property
    def messages_per_round(self) -> int:
        """Return the number of state messages until every board has reported once."""
        if self.link.state_message == "value":
            return sum(len(board.channels) for board in self.heard)
        return len(self.heard)
