"""Signals of a robot that are computed from raw counts or from other signals."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, Tag

from pirate_sm.core._model.base import Frozen, Name, by_key
from pirate_sm.core._model.quantities import Duration, Speed


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
