"""A robot's profile: everything that the engine and the backends know about a robot.

The models correspond to ``profile.yaml`` key by key. :mod:`pirate_sm.core._loading.robot` checks
the references (a slot to a joint, a command to the chart) and reports each fault with its place.
"""

from __future__ import annotations

from math import asin, pi, radians, remainder
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from pirate_sm.core._geometry.route import JointKind, JointOrEnd
from pirate_sm.core._geometry.space import Frame, Vector, dot
from pirate_sm.core._model.base import OR_ONE, Condition, FaultCode, Format, Frozen, Name
from pirate_sm.core._model.quantities import (
    Angle,
    Count,
    Duration,
    Flag,
    Length,
    PositiveDuration,
    Ratio,
)
from pirate_sm.core._model.robot.actuation import Control, PostureCase, Stages
from pirate_sm.core._model.robot.body import Body, Motor
from pirate_sm.core._model.robot.done_criteria import Criterion
from pirate_sm.core._model.robot.limits import Plausibility
from pirate_sm.core._model.robot.seen_states import Seen
from pirate_sm.core._model.robot.signals import Conversion, Derived, DerivedSignal, Serial
from pirate_sm.core._model.robot.simulation import Simulation

_OFF_RAD = radians(15)
"""How far an opening may be off the direction of a passage: rolled by 15 deg against a mitre, an
elbow or a branch, a robot passes it 6 times of 6, by 20 deg 3 to 6 times, by 30 deg 0 to 3 times
[measured in 3-D, 120 mm, flat]."""

_LYING_RAD = radians(45)
"""How far a robot may be off the roll of a turn: half way to the next one [decided]."""


class Turn(Frozen):
    """A mission that turns the robot about the pipe's axis, where it stands.

    Attributes:
        call: The mission.
        rolls: By how much it turns the robot, side A up where the pipe is flat.
        lying: Rolls against the horizontal from which it turns: 90 deg has side A up in normal
            polarity. Absent: any.
        upright: Which way an upright leg leads in which it turns; absent: in none.
    """

    call: str
    rolls: Angle
    lying: tuple[Angle, ...] = ()
    upright: Literal["up", "down"] | None = None

    def turns_from(self, rolled_rad: float) -> bool:
        """Return whether it turns a robot that is rolled so against the horizontal."""
        off = (abs(remainder(rolled_rad - each, 2 * pi)) for each in self.lying)
        return not self.lying or any(angle <= _LYING_RAD + 1e-9 for angle in off)


class PassedBy(Frozen):
    """A kind of joint, and the missions that pass it.

    Attributes:
        joints: The kinds of joints.
        turns: Whether the route turns there, or leads straight on; absent: either.
        up_to: The sharpest turn of the route that these pass. Absent: any.
        towards: Directions of the turn or of the opening about the direction of travel, against the
            robot's plane: 0 deg is towards side A in normal polarity. Absent: any.
        calls: The missions that pass it, one after the other; none: the robot drives on.
    """

    joints: Annotated[tuple[JointKind, ...], Field(min_length=1)]
    turns: bool | None = None
    up_to: Angle | None = None
    towards: tuple[Angle, ...] = ()
    calls: tuple[str, ...] = ()

    def suits(self, kind: JointKind, turn_rad: float) -> bool:
        """Return whether this is for a joint of a kind at which the route turns by an angle."""
        asked = self.turns in (None, bool(turn_rad))
        sharp = self.up_to is not None and abs(turn_rad) > self.up_to + 1e-9
        return kind in self.joints and asked and not sharp

    def passes(self, kind: JointKind, turn_rad: float, towards_rad: float) -> bool:
        """Return whether this passes a joint of a kind that turns towards a direction."""
        if not self.suits(kind, turn_rad):
            return False
        off = (abs(remainder(towards_rad - each, 2 * pi)) for each in self.towards)
        return not self.towards or any(angle <= _OFF_RAD for angle in off)


class Travel(Frozen):
    """The missions that a mission along a route is made of; each begins and ends in one state.

    Attributes:
        starts_in: This state of the robot.
        last: The mission that drives on to the end of the route; its parameter `way` says how far.
        passages: What passes the joints; the first that fits is taken.
        turns: What turns the robot before a joint that no passage fits.
        upright: From which slope on a leg is upright for these.
    """

    starts_in: dict[str, str] = {}
    last: str
    turns: tuple[Turn, ...] = ()
    upright: Annotated[Angle, Field(gt=0)] = radians(77)
    passages: tuple[PassedBy, ...] = ()

    def is_upright(self, frame: Frame, up: Vector) -> bool:
        """Return whether a leg with this frame is upright for these missions."""
        return abs(_climbs_rad(frame, up)) >= self.upright

    def turns_at(self, turn: Turn, frame: Frame, up: Vector, roll_rad: float) -> bool:
        """Return whether a mission turns a robot of this roll in a leg with this frame."""
        if self.is_upright(frame, up):
            return turn.upright == ("up" if _climbs_rad(frame, up) > 0 else "down")
        return turn.turns_from(roll_rad - (frame.roll_of(up) - pi / 2))


def _climbs_rad(frame: Frame, up: Vector) -> float:
    """Return how steep a leg climbs."""
    return asin(min(max(dot(frame.ahead, up), -1.0), 1.0))


class Slot(Frozen):
    """One setpoint on the wire and what it drives.

    Attributes:
        name: Name of the slot.
        unit: ``duty``: -1..1 of full voltage. ``angle``: rad, the board has its own controller.
        motor: The kind of motor that it drives.
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

    @property
    def drives(self) -> Name:
        """Return the joint, wheel or roll joint that it drives; empty where it drives none."""
        return self.joint or self.wheel or self.roll or ""


SlotSense: TypeAlias = Literal["angle", "torque", "current", "turned"]
"""Quantities measured at a slot's joint, wheel or roll joint; others belong to the body."""

Sense: TypeAlias = Literal[SlotSense, "acc_x", "acc_y", "acc_z", "mag_x", "mag_y", "mag_z"]


class Channel(Frozen):
    """One raw value of a board; without a signal it is transmitted but not interpreted.

    Attributes:
        name: Name of the channel.
        signal: Its name in conditions.
        convert: Conversion from raw to SI.
        senses: The measured quantity, for simulators. ``turned`` is a mean of differences of an
            angle (thesis B-11).
        slot: The slot whose joint, wheel or roll joint is measured.
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
        module: The module that contains it.
        fitted: ``false`` for a missing board; its place on the wire is kept.
        channels_fitted: ``false`` if its sensors are missing; their place on the wire is kept.
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
    """Timing and resolution of the link to the boards.

    Attributes:
        cycle: Interval of the state messages.
        state_message: ``board``: one message per board. ``value``: one per value.
        echo_delay: Time until a setpoint array is confirmed.
        duty_resolution: Step of a duty cycle on the wire.
        angle_resolution: Step of an angle on the wire.
        stale_after: A signal that is not reported for this long is unknown.
        silent_after: A board that is silent for this long is a fault; all boards mean a lost link.
        resend_after: An array without a result is sent again after this long.
        resend_limit: How often an array without a result is sent again.
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


class Command(Frozen):
    """The properties of a command that the chart does not define.

    Attributes:
        asks_for: Condition on states. Where it already holds, the command is unneeded.
        done: The criterion of its completion.
        timeout: Time from acceptance after which the command fails.
        nominal: Nominal duration, for backends without motion.
        lets_go: Whether it may release the last confirmed clamp.
        posture: The posture that the robot reaches before the actuation of the states.
        description: One-line description.
    """

    asks_for: Condition
    done: Criterion
    timeout: PositiveDuration
    nominal: PositiveDuration
    lets_go: Flag = False
    posture: Name | None = None
    description: str = ""


class SafeState(Frozen):
    """The safe state: slots that go to zero, while all others keep their last accepted value.

    Attributes:
        zero: Slots that go to zero; all others keep their last accepted value.
    """

    zero: Annotated[tuple[Name, ...], Field(min_length=1)]


class FaultRule(Frozen):
    """A fault that is derived from signals: a condition that has held for a time.

    Attributes:
        code: Code of the fault, ``family.detail``.
        when: The condition; ``{i}`` is replaced by each of ``for_each``, ``$JOINT_stop`` by the
            end stop of a joint.
        held: How long it must have been true without interruption.
        message: The message for the operator.
        catchable: ``false`` for a fault that no mission may handle.
        for_each: The rule is repeated for each of these numbers, instead of ``{i}``.
        denies: Parts whose clamps do not hold: while the rule is true they are not confirmed,
            whatever a command's criterion shows.
        of: Boards, joints, wheels and parts that it is a fault of, by name, with ``{i}`` as above;
            those of ``denies`` where nothing is given.
    """

    code: FaultCode
    when: Condition
    held: Annotated[Duration, Field(ge=0)]
    message: str
    catchable: Flag = True
    for_each: tuple[Count, ...] = ()
    denies: tuple[Name, ...] = ()
    of: Annotated[tuple[str, ...], *OR_ONE] = ()


class SafetyRule(Frozen):
    """A safety rule: a condition that must always or never hold, whatever a mission commands.

    Exactly one of ``always``, ``never`` and ``expect`` is given. Conditions see the state of each
    region, ``command`` (just accepted), ``clamps`` (parts that the states hold),
    ``confirmed_clamps`` and ``driven_wheels``.

    Attributes:
        rule: Name of the rule.
        always: A condition that must hold.
        never: A condition that must not hold.
        after: The rule applies once this has been true.
        expect: A condition that must become true in time after ``after``.
        within_steps: With ``expect``: how many commands may be accepted until it holds.
        why: What happens if the rule is broken.
        waived_by: The key of a mission that waives the rule, with a reason.
    """

    rule: Name
    always: Condition | None = None
    never: Condition | None = None
    after: Condition | None = None
    expect: Condition | None = None
    within_steps: Annotated[Count, Field(ge=1, le=1000)] | None = None
    why: str = ""
    waived_by: Literal["allow_unclamp"] | None = None

    @model_validator(mode="after")
    def _one_of_three(self) -> SafetyRule:
        if sum(each is not None for each in (self.always, self.never, self.expect)) != 1:
            raise ValueError("expected exactly one of `always`, `never` and `expect`")
        if (self.expect is None) != (self.within_steps is None):
            raise ValueError("`expect` and `within_steps` go together")
        if self.expect is not None and self.after is None:
            raise ValueError("`expect` needs `after`: what it is expected to follow")
        return self


class DetectorPoint(Frozen):
    """A wheel and its distance beyond the intersection of the pipe's axes, along the pipe.

    Attributes:
        wheel: The wheel.
        passed: Its distance beyond the intersection of the pipe's axes; negative: before it.
    """

    wheel: Name
    passed: Length


class DetectorDefinition(Frozen):
    """When a detector's word is valid: from a point on for each direction, by a condition, or both.

    Attributes:
        forward: The point when driving forward, for detectors that know where the robot is.
        backward: The point when driving backward.
        when: The condition on signals and states, for the detector ``signals``.
        held: How long the condition must have been true without interruption.
        joint: The kind of joint that it announces, where its detector can know that.
    """

    forward: DetectorPoint | None = None
    backward: DetectorPoint | None = None
    when: Condition | None = None
    held: Annotated[Duration, Field(ge=0)] = 0.0
    joint: JointOrEnd | None = None

    @model_validator(mode="after")
    def _is_said_somehow(self) -> Self:
        if (self.forward is None) != (self.backward is None):
            raise ValueError("`forward` and `backward` belong together")
        if self.forward is None and self.when is None:
            raise ValueError("expected `forward` and `backward`, or `when`")
        if self.held and self.when is None:
            raise ValueError("`held` belongs to `when`")
        return self


class Detector(Frozen):
    """The words that a detector may report, each valid for a limited time.

    Attributes:
        valid_for: How long a word is valid, unless another one is reported.
        words: The words, and the point from which each is valid.
    """

    valid_for: PositiveDuration
    words: Annotated[dict[Name, DetectorDefinition], Field(min_length=1)]


class OutsideSignal(Frozen):
    """A number that somebody outside the robot measures, such as a ruler or a camera.

    Attributes:
        unit: Its unit, such as ``m/s``; it is reported in SI.
        valid_for: How long a value counts unless a newer one comes; then it is unknown.
        averages: The time over which a value is the mean, up to its arrival; 0 s for a moment.
    """

    unit: str
    valid_for: PositiveDuration
    averages: Annotated[Duration, Field(ge=0)] = 0.0


class Profile(Frozen):
    """A whole robot.

    Attributes:
        format: Version of this format.
        robot: Name of the robot.
        description: One-line description.
        chart: The chart's file, in the same folder.
        body: The planar chain of wheels and links.
        motors: Kinds of motors by name, to which slots refer.
        boards: The boards in the order of the wire.
        link: Timing and resolution of the link.
        plausibility: Limits beyond which a sensor is wrong.
        conversions: Scales from raw counts to SI, by name.
        derived: Signals that are computed from others, by name.
        outside: Signals that are measured outside the robot.
        actuation: For each region and each of its states, what the slots get.
        controls: Other ways to actuate the states, by the name that a mission chooses them by.
        postures: What commands bring the joints to first, by name. Of each posture the first
            case counts whose condition holds; where none holds, the command needs no posture.
        commands: One entry for each event of the chart.
        aliases: Other names of commands: ``{other: command}``.
        not_commands: Names that users may try as commands, each with an explanation.
        seen: Criteria by which sensors confirm states before anything moves.
        safe_state: The safe state.
        faults: Faults that are derived from signals.
        rules: Safety rules, against which missions are checked, and every run is monitored.
        detector: The words of a detector.
        travel: How it travels along routes; absent for a robot that cannot.
        simulation: Settings for the simulator only.
        serial: The serial link; absent for a robot that is only simulated.
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
    outside: dict[Name, OutsideSignal] = {}
    actuation: dict[Name, dict[Name, Stages]]
    controls: dict[Name, Control] = {}
    postures: dict[Name, Annotated[tuple[PostureCase, ...], Field(min_length=1)]] = {}
    commands: dict[Name, Command]
    aliases: dict[Name, Name] = {}
    not_commands: dict[Name, str] = {}
    seen: Seen = Seen()
    safe_state: SafeState
    faults: tuple[FaultRule, ...] = ()
    rules: tuple[SafetyRule, ...] = ()
    detector: Detector
    travel: Travel | None = None
    simulation: Simulation
    serial: Serial | None = None

    @property
    def slots(self) -> tuple[Slot, ...]:
        """Return all slots in the order of the wire."""
        return tuple(slot for board in self.boards for slot in board.slots)

    def derived_by(self, kind: type[DerivedSignal], **keys: str) -> str:
        """Return the first derived signal of a kind with these keys; empty where there is none."""
        for name, it in self.derived.items():
            if isinstance(it, kind) and all(getattr(it, key) == keys[key] for key in keys):
                return name
        return ""

    @property
    def heard(self) -> tuple[Board, ...]:
        """Return the boards that report, in the order of their reports."""
        return tuple(b for b in self.boards if b.fitted and b.channels_fitted and b.channels)

    @property
    def messages_per_round(self) -> int:
        """Return the number of state messages until every board has reported once."""
        if self.link.state_message == "value":
            return sum(len(board.channels) for board in self.heard)
        return len(self.heard)
