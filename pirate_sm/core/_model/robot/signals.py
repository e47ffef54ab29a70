"""Signals of a robot: the serial link that brings them, and what is derived from others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar, Final, Literal, TypeAlias, get_args

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core._model.base import Frozen, Name, by_key
from pirate_sm.core._model.quantities import Count, Duration, PositiveDuration, Speed
from pirate_sm.core._model.robot.body import Body
from pirate_sm.core.units import (
    ANGLE,
    DIMENSIONLESS,
    FORCE,
    LENGTH,
    SPEED,
    TIME,
    TORQUE,
    Dimension,
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


Operation: TypeAlias = Literal["rate", "torque", "roll", "pitch", "norm", "diameter"]
"""What a row of the table of signals does, see :mod:`pirate_sm.core._engine.sensing.evaluator`."""

_OPERANDS: Final[Mapping[Operation, tuple[range, int, int]]] = {
    "rate": (range(1, 2), 0, 0), "torque": (range(1, 2), 1, 1), "norm": (range(1, 4), 0, 0),
    "roll": (range(3, 4), 0, 0), "pitch": (range(3, 4), 0, 0), "diameter": (range(1, 2), 0, 2),
}  # fmt: skip
"""How many signals, setpoints and constants each operation takes."""


@dataclass(frozen=True, slots=True)
class SignalRow:
    """One of the operations that a derived signal is made of.

    It is refused with operands that the table would drop or fill with zeros.

    Attributes:
        operation: What it does.
        sources: The signals that it takes first; among them may be the derived one as it is so far.
        slot: The slot whose setpoint it takes next; empty for none.
        constants: What it takes last: numbers in SI units, or constant expressions.
    """

    operation: Operation
    sources: tuple[str, ...]
    slot: str = ""
    constants: tuple[float | str, ...] = ()

    def __post_init__(self) -> None:
        signals, setpoints, constants = _OPERANDS[self.operation]
        given = bool(self.slot), len(self.constants)
        if len(self.sources) not in signals or given != (setpoints, constants):
            raise TypeError(
                f"the operation '{self.operation}' does not take these operands: {self}"
            )


DerivedFrom: TypeAlias = Literal["signals", "axes", "wheels", "parts", "odometry"]
"""What the first key of a kind of derived signal names; axes are x, y and z of an accelerometer."""


class DerivedSignal(Frozen):
    """A kind of derived signal, with its keys.

    ``OF`` is what its first key names, ``DIMENSION`` that of the signal, by default that of the
    first of them. ``OPERATION`` makes the signal of them in a frame of their board, if they are
    signals or axes; a kind that needs more has `rows` of its own. One with neither is made of the
    frames of several boards.
    """

    OF: ClassVar[DerivedFrom] = "signals"
    DIMENSION: ClassVar[Dimension | None] = None
    OPERATION: ClassVar[Operation | None] = None

    @classmethod
    def __pydantic_init_subclass__(cls, **_: object) -> None:
        """Refuse an operation on anything but signals, which no frame would ever give."""
        if cls.OPERATION and (cls.OF not in ("signals", "axes") or cls.OPERATION not in _OPERANDS):
            raise TypeError(
                f"{cls.__name__} needs rows(): no '{cls.OPERATION}' is made of {cls.OF}"
            )

    @classmethod
    def key(cls) -> str:
        """Return the key by which a profile chooses this kind."""
        return next(iter(cls.model_fields))

    @property
    def sources(self) -> tuple[str, ...]:
        """Return what it is derived from."""
        value: str | tuple[str, ...] = getattr(self, self.key())
        return (value,) if isinstance(value, str) else value

    def dimension(self, own: Dimension) -> Dimension:
        """Return its dimension if that of what it is derived from is ``own``."""
        return own if self.DIMENSION is None else self.DIMENSION

    def rows(self, name: str, body: Body) -> Iterator[SignalRow]:
        """Yield the operations by which a frame gives the signal of this name."""
        if self.OPERATION:
            yield SignalRow(self.OPERATION, self.sources)


class RateOf(DerivedSignal):
    """Difference of a signal between two frames, divided by their time interval (thesis B-11).

    Attributes:
        rate_of: The signal.
    """

    OPERATION: ClassVar = "rate"

    rate_of: Name

    def dimension(self, own: Dimension) -> Dimension:
        """Return the dimension of a rate."""
        return own / TIME


class TorqueOf(DerivedSignal):
    """Current times ``scale`` with the sign of a slot's setpoint (thesis eq. 5-3).

    Attributes:
        torque_of: The signal of the current.
        slot: The slot whose setpoint gives the sign.
        scale: Torque per current, a constant expression such as ``0.9 Nm/A``.
    """

    DIMENSION: ClassVar = TORQUE

    torque_of: Name
    slot: Name
    scale: str

    def rows(self, name: str, body: Body) -> Iterator[SignalRow]:
        """Yield the operation."""
        yield SignalRow("torque", self.sources, self.slot, (self.scale,))


class RollOf(DerivedSignal):
    """Roll from an accelerometer's x, y, z (thesis B-13).

    Attributes:
        roll_of: The signals x, y and z of the accelerometer.
    """

    OF: ClassVar = "axes"
    DIMENSION: ClassVar = ANGLE
    OPERATION: ClassVar = "roll"

    roll_of: Annotated[tuple[Name, ...], Field(min_length=3, max_length=3)]


class PitchOf(DerivedSignal):
    """Pitch from an accelerometer's x, y, z (thesis B-14).

    Attributes:
        pitch_of: The signals x, y and z of the accelerometer.
    """

    OF: ClassVar = "axes"
    DIMENSION: ClassVar = ANGLE
    OPERATION: ClassVar = "pitch"

    pitch_of: Annotated[tuple[Name, ...], Field(min_length=3, max_length=3)]


class NormOf(DerivedSignal):
    """Length of the vector of these signals.

    Attributes:
        norm_of: The signals.
    """

    norm_of: Annotated[tuple[Name, ...], Field(min_length=1)]

    def rows(self, name: str, body: Body) -> Iterator[SignalRow]:
        """Yield the norm of the first three, and with each two more that of it and them."""
        first, others = self.norm_of[0], self.norm_of[1:]
        for at in range(0, max(len(others), 1), 2):
            yield SignalRow("norm", (name if at else first, *others[at : at + 2]))


class DiameterOf(DerivedSignal):
    """Inner diameter at a clamped part, h + 2r (thesis eq. 3-2).

    Attributes:
        diameter_of: The part.
    """

    OF: ClassVar = "parts"
    DIMENSION: ClassVar = LENGTH

    diameter_of: Name

    def rows(self, name: str, body: Body) -> Iterator[SignalRow]:
        """Yield the operation. Eq. 3-2 assumes two legs of equal length."""
        apex, leg_m = body.parts[self.diameter_of].apex, body.legs_m(self.diameter_of)[0]
        yield SignalRow("diameter", (apex,), constants=(leg_m, 2 * body.wheel_radius))


class OdometryOf(DerivedSignal):
    """Distance rolled forward: mean over the driven ones among these wheels.

    Attributes:
        odometry_of: The wheels.
    """

    OF: ClassVar = "wheels"
    DIMENSION: ClassVar = LENGTH

    odometry_of: Annotated[tuple[Name, ...], Field(min_length=1)]


class BoundOf(DerivedSignal):
    """How far the robot may be from the distance that its odometry shows.

    Attributes:
        bound_of: The signal of the odometry.
    """

    OF: ClassVar = "odometry"
    DIMENSION: ClassVar = LENGTH

    bound_of: Name


class SpeedOf(DerivedSignal):
    """Forward speed: mean rim speed of the driven ones among these wheels.

    Attributes:
        speed_of: The wheels.
    """

    OF: ClassVar = "wheels"
    DIMENSION: ClassVar = SPEED

    speed_of: Annotated[tuple[Name, ...], Field(min_length=1)]


class TractionSignal(DerivedSignal):
    """A signal of slip, normal force or friction, which is made of all boards."""

    OF: ClassVar[DerivedFrom] = "wheels"


class RobotSpeedOf(TractionSignal):
    """Speed of the body: as measured from outside, else the median of the wheels that agree.

    Attributes:
        robot_speed_of: The wheels.
        measured: The outside signal that measures it.
        agreeing: How far a wheel's rim speed may differ from the median of all.
    """

    DIMENSION: ClassVar = SPEED

    robot_speed_of: Annotated[tuple[Name, ...], Field(min_length=1)]
    measured: Name
    agreeing: Annotated[Speed, Field(gt=0)] = 0.010


class SlipSpeedOf(TractionSignal):
    """Speed of a wheel's rim less that of the body (thesis fig. 6-7).

    Attributes:
        slip_speed_of: The wheel.
        speed: The body speed that is measured from outside, or the signal that falls back from it.
    """

    DIMENSION: ClassVar = SPEED

    slip_speed_of: Name
    speed: Name


class SlipOf(TractionSignal):
    """Slip ratio of a wheel, (v - r d omega) / v (thesis eq. 2-1).

    Attributes:
        slip_of: The wheel.
        speed: The body speed, see ``slip_speed_of``.
        unknown_below: Body speed below which the ratio means nothing.
    """

    DIMENSION: ClassVar = DIMENSIONLESS

    slip_of: Name
    speed: Name
    unknown_below: Annotated[Speed, Field(gt=0)]


class NormalForceOf(TractionSignal):
    """How hard a wheel presses on its wall, by the statics of the chain.

    Attributes:
        normal_force_of: The wheel.
    """

    DIMENSION: ClassVar = FORCE

    normal_force_of: Name


class FrictionUsedOf(TractionSignal):
    """Force of a wheel along the wall over its normal force: a lower bound of the friction.

    Attributes:
        friction_used_of: The wheel.
    """

    DIMENSION: ClassVar = DIMENSIONLESS

    friction_used_of: Name


class FrictionOf(TractionSignal):
    """Coefficient of kinetic friction of a wheel, known while it slips the way it is driven.

    Attributes:
        friction_of: The wheel.
        slip_above: Slip speed from which on it is estimated.
        steady: For how long the wheel must have slipped.
    """

    DIMENSION: ClassVar = DIMENSIONLESS

    friction_of: Name
    slip_above: Annotated[Speed, Field(gt=0)]
    steady: Annotated[Duration, Field(ge=0)]


class LeastOf(TractionSignal):
    """The least of the signals that are known.

    Attributes:
        least_of: The signals, all of one kind.
    """

    OF: ClassVar = "signals"

    least_of: Annotated[tuple[Name, ...], Field(min_length=1)]


_Kinds: TypeAlias = (
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
    | Annotated[LeastOf, Tag("least_of")]
)
_KEYS = [get_args(kind)[0].key() for kind in get_args(_Kinds)]

Derived: TypeAlias = Annotated[
    _Kinds,
    by_key(
        _KEYS,
        custom_error_type="derived",
        custom_error_message="expected a mapping with one of " + ", ".join(_KEYS),
    ),
]
