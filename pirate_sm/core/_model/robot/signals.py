"""Signals of a robot: the serial link that brings them, their limits, and derived signals."""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core._model.base import Frozen, Name, by_key
from pirate_sm.core._model.quantities import (
    Acceleration,
    Angle,
    Count,
    Duration,
    Number,
    PositiveDuration,
    Ratio,
    Speed,
)

TypeName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z]\w*/[A-Za-z]\w*$")]
"""A ROS message type as on the wire, ``package/Type``."""


class SetpointTopic(Frozen):
    """A topic that carries a whole array of setpoints, or its echo.

    Attributes:
        topic: Name of the topic.
        type: Its message type, ``package/Type``.
        id: Field with the id of the array.
        values: Field with one integer per slot.
        hold: Field with one bit per slot, the lowest for slot 0: set if the firmware's dead man's
            switch keeps the slot's value, clear if it writes 0. If it is the id's field, these are
            the upper bits of the id. Empty: the message has no such bits.
    """

    topic: str
    type: TypeName
    id: Name = "id"
    values: Name = "setpoints"
    hold: Name | Literal[""] = ""


class StateTopic(Frozen):
    """The topic with the measurements of the boards.

    Attributes:
        topic: Name of the topic.
        type: Its message type, ``package/Type``.
        layout: ``board``: all channels of one board in ``values``. ``value``: one ``value`` of one
            ``channel``.
        board: Field with the board's id.
        channel: Field with the channel's number.
        values: Field with the values of all channels of a board.
        value: Field with the value of one channel.
    """

    topic: str
    type: TypeName
    layout: Literal["board", "value"]
    board: Name = "board"
    channel: Name = "channel"
    values: Name = "values"
    value: Name = "value"


class Advice(Frozen):
    """Advice for problems that no message of the link reports; empty where there is none.

    Attributes:
        no_motion: Advice if motors ignore setpoints.
        no_sensors: Advice if no board reports.
        motor_error: Advice if one motor does not move.
    """

    no_motion: str = ""
    no_sensors: str = ""
    motor_error: str = ""


class Serial(Frozen):
    """The serial link to the robot, rosserial protocol revision 1.

    Attributes:
        baud: Baud rate of the port.
        boot: Longest duration of the boot loader after the port is opened.
        echo_within: An array not echoed for this long is sent again.
        recover_within: The link is lost if a silent controller or a missing port is not back within
            this time after the boot loader's time.
        refresh_every: The array in force is written again if nothing else was written for this
            long, earlier on a lossy line. Without this key nothing is repeated.
        stop_after: The firmware's dead man's switch stops every slot without a hold bit after this
            time without a valid array. Without this key the firmware has no such switch.
        heartbeat_within: The guardian sends the safe array after this time without a message from
            the runner.
        messages: Folder in the robot's folder with one ``<Type>.msg`` per message type.
        setpoints: The topic for arrays of setpoints.
        echo: The topic on which the controller repeats each accepted array.
        state: The topic with the measurements of the boards.
        advice: Advice for problems that no message reports.
    """

    baud: Annotated[Count, Field(gt=0)]
    boot: Duration
    echo_within: PositiveDuration
    recover_within: PositiveDuration = 6.0
    refresh_every: PositiveDuration | None = None
    stop_after: PositiveDuration | None = None
    heartbeat_within: PositiveDuration
    messages: str = "messages"
    setpoints: SetpointTopic
    echo: SetpointTopic
    state: StateTopic
    advice: Advice = Advice()

    @model_validator(mode="after")
    def _refreshed_in_time(self) -> Serial:
        if self.stop_after is None:
            return self
        if self.refresh_every is None:
            raise ValueError(
                "'stop_after' needs 'refresh_every': without repeats the firmware's switch stops "
                "the robot whenever a mission waits"
            )
        if 2 * self.refresh_every > self.stop_after:
            raise ValueError(
                f"'refresh_every' is {self.refresh_every:g} s and 'stop_after' "
                f"{self.stop_after:g} s: at least two repeats must fit, or one lost frame stops "
                "the robot"
            )
        return self


class Conversion(Frozen):
    """A raw count times ``scale``, which is a constant expression with a unit.

    Attributes:
        scale: A constant expression with a unit, such as ``360 deg / 4096``.
    """

    scale: str


class RateOf(Frozen):
    """Difference of a signal between two frames, divided by their time interval (thesis B-11).

    Attributes:
        rate_of: The signal.
    """

    rate_of: Name


class TorqueOf(Frozen):
    """Current times ``scale`` with the sign of a slot's setpoint (thesis eq. 5-3).

    Attributes:
        torque_of: The signal of the current.
        slot: The slot whose setpoint gives the sign.
        scale: Torque per current, a constant expression such as ``0.9 Nm/A``.
    """

    torque_of: Name
    slot: Name
    scale: str


class RollOf(Frozen):
    """Roll from an accelerometer's x, y, z (thesis B-13).

    Attributes:
        roll_of: The signals x, y and z of the accelerometer.
    """

    roll_of: Annotated[tuple[Name, ...], Field(min_length=3, max_length=3)]


class PitchOf(Frozen):
    """Pitch from an accelerometer's x, y, z (thesis B-14).

    Attributes:
        pitch_of: The signals x, y and z of the accelerometer.
    """

    pitch_of: Annotated[tuple[Name, ...], Field(min_length=3, max_length=3)]


class NormOf(Frozen):
    """Length of the vector of these signals.

    Attributes:
        norm_of: The signals.
    """

    norm_of: Annotated[tuple[Name, ...], Field(min_length=1)]


class DiameterOf(Frozen):
    """Inner diameter at a clamped part, h + 2r (thesis eq. 3-2).

    Attributes:
        diameter_of: The part.
    """

    diameter_of: Name


class OdometryOf(Frozen):
    """Distance rolled forward: mean over the driven ones among these wheels.

    Attributes:
        odometry_of: The wheels.
    """

    odometry_of: Annotated[tuple[Name, ...], Field(min_length=1)]


class BoundOf(Frozen):
    """How far the robot may be from the distance that its odometry shows.

    Attributes:
        bound_of: The signal of the odometry.
    """

    bound_of: Name


class SpeedOf(Frozen):
    """Forward speed: mean rim speed of the driven ones among these wheels.

    Attributes:
        speed_of: The wheels.
    """

    speed_of: Annotated[tuple[Name, ...], Field(min_length=1)]


class RobotSpeedOf(Frozen):
    """Speed of the body: as measured from outside, else the median of the wheels that agree.

    Attributes:
        robot_speed_of: The wheels.
        measured: The outside signal that measures it.
        agreeing: How far a wheel's rim speed may differ from the median of all.
    """

    robot_speed_of: Annotated[tuple[Name, ...], Field(min_length=1)]
    measured: Name
    agreeing: Annotated[Speed, Field(gt=0)] = 0.010


class SlipSpeedOf(Frozen):
    """Speed of a wheel's rim less that of the body (thesis fig. 6-7).

    Attributes:
        slip_speed_of: The wheel.
        speed: The body speed that is measured from outside, or the signal that falls back from it.
    """

    slip_speed_of: Name
    speed: Name


class SlipOf(Frozen):
    """Slip ratio of a wheel, (v - r d omega) / v (thesis eq. 2-1).

    Attributes:
        slip_of: The wheel.
        speed: The body speed, see ``slip_speed_of``.
        unknown_below: Body speed below which the ratio means nothing.
    """

    slip_of: Name
    speed: Name
    unknown_below: Annotated[Speed, Field(gt=0)]


class NormalForceOf(Frozen):
    """How hard a wheel presses on its wall, by the statics of the chain.

    Attributes:
        normal_force_of: The wheel.
    """

    normal_force_of: Name


class FrictionUsedOf(Frozen):
    """Force of a wheel along the wall over its normal force: a lower bound of the friction.

    Attributes:
        friction_used_of: The wheel.
    """

    friction_used_of: Name


class FrictionOf(Frozen):
    """Coefficient of kinetic friction of a wheel, known while it slips the way it is driven.

    Attributes:
        friction_of: The wheel.
        slip_above: Slip speed from which on it is estimated.
        steady: For how long the wheel must have slipped.
    """

    friction_of: Name
    slip_above: Annotated[Speed, Field(gt=0)]
    steady: Annotated[Duration, Field(ge=0)]


class LeastOf(Frozen):
    """The least of the signals that are known.

    Attributes:
        least_of: The signals, all of one kind.
    """

    least_of: Annotated[tuple[Name, ...], Field(min_length=1)]


Traction: TypeAlias = (
    RobotSpeedOf | SlipSpeedOf | SlipOf | NormalForceOf | FrictionUsedOf | FrictionOf | LeastOf
)
"""Signals of slip, normal force and friction, which are made of all boards."""


DERIVED_KINDS = (
    "rate_of", "torque_of", "roll_of", "pitch_of", "norm_of", "diameter_of", "odometry_of",
    "bound_of", "speed_of", "robot_speed_of", "slip_speed_of", "slip_of", "normal_force_of",
    "friction_used_of", "friction_of", "least_of",
)  # fmt: skip


Derived: TypeAlias = Annotated[
    Annotated[RateOf, Tag("rate_of")]
    | Annotated[TorqueOf, Tag("torque_of")]
    | Annotated[RollOf, Tag("roll_of")]
    | Annotated[PitchOf, Tag("pitch_of")]
    | Annotated[NormOf, Tag("norm_of")]
    | Annotated[DiameterOf, Tag("diameter_of")]
    | Annotated[OdometryOf, Tag("odometry_of")]
    | Annotated[BoundOf, Tag("bound_of")]
    | Annotated[SpeedOf, Tag("speed_of")]
    | Annotated[RobotSpeedOf, Tag("robot_speed_of")]
    | Annotated[SlipSpeedOf, Tag("slip_speed_of")]
    | Annotated[SlipOf, Tag("slip_of")]
    | Annotated[NormalForceOf, Tag("normal_force_of")]
    | Annotated[FrictionUsedOf, Tag("friction_used_of")]
    | Annotated[FrictionOf, Tag("friction_of")]
    | Annotated[LeastOf, Tag("least_of")],
    by_key(
        DERIVED_KINDS,
        custom_error_type="derived",
        custom_error_message="expected a mapping with one of " + ", ".join(DERIVED_KINDS),
    ),
]


_Factor = Annotated[Number, Field(gt=0)]
_PositiveAngle = Annotated[Angle, Field(gt=0)]
_Readings = Annotated[Count, Field(ge=1)]


class Plausibility(Frozen):
    """Limits beyond which a sensor is wrong in any situation.

    Attributes:
        overspeed: Largest speed of an angle as a multiple of the no-load speed of its motor; other
            motors may push it. A joint whose spring's torque is measured has no such allowance.
        joint_slack: Additional change of a joint allowed between two readings.
        wheel_slack: Additional change of a wheel allowed between two readings.
        beyond_stop: How far a joint's angle may be beyond its end stop.
        overcurrent: Largest current as a multiple of the motor's stall current.
        overtorque: Largest torque as a multiple of the motor's stall torque; outside forces can
            wind up a spring behind a self-locking gear.
        acceleration: Largest magnitude of each number of an accelerometer; without one all are
            believed.
        hold_back: Number of readings for which the last believed value replaces an impossible one.
        spikes: Number of spikes of one sensor within ``spikes_within`` that is a fault.
        spikes_within: Duration in which spikes are counted.
        stuck_after: A sensor is stuck if it shows the same value for this long while its motor is
            driven without load.
        unloaded: A motor is without load below this share of its stall current at the same duty
            cycle.
        surely_driven: A motor certainly turns above this multiple of the least duty cycle of its
            position loop.
        settle: All motion ends within this time after the last change of a setpoint.
        joint_moved: Smallest change of a joint that counts as motion.
        wheel_moved: Smallest change of a wheel that counts as motion.
        moved_readings: Number of consecutive readings that must show an unexpected motion.
        spring: By this share a joint's spring may be stiffer or softer than its motor says.
        repeats: A joint may have turned for this long although its board repeats its angle.
    """

    overspeed: _Factor = 3.0
    joint_slack: _PositiveAngle = radians(6)
    wheel_slack: _PositiveAngle = 1.0
    beyond_stop: _PositiveAngle = radians(12)
    overcurrent: _Factor = 2.0
    overtorque: _Factor = 8.0
    acceleration: Annotated[Acceleration, Field(gt=0)] | None = None
    hold_back: Count = 2
    spikes: _Readings = 5
    spikes_within: PositiveDuration = 10.0
    stuck_after: PositiveDuration = 1.5
    unloaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.4
    surely_driven: _Factor = 1.5
    settle: PositiveDuration = 1.5
    joint_moved: _PositiveAngle = radians(20)
    wheel_moved: _PositiveAngle = 1.0
    moved_readings: _Readings = 2
    spring: Annotated[Ratio, Field(ge=0, lt=1)] = 0.0
    repeats: PositiveDuration = 0.2
