"""Signals of a robot that are computed from raw counts or from other signals."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, Tag

from pirate_sm.model.base import Frozen, Name, by_key


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


class SpeedOf(Frozen):
    """Forward speed: mean rim speed of the driven ones among these wheels.

    Attributes:
        speed_of: The wheels.
    """

    speed_of: Annotated[tuple[Name, ...], Field(min_length=1)]


DERIVED_KINDS = (
    "rate_of", "torque_of", "roll_of", "pitch_of", "norm_of", "diameter_of", "odometry_of",
    "speed_of",
)  # fmt: skip


Derived: TypeAlias = Annotated[
    Annotated[RateOf, Tag("rate_of")]
    | Annotated[TorqueOf, Tag("torque_of")]
    | Annotated[RollOf, Tag("roll_of")]
    | Annotated[PitchOf, Tag("pitch_of")]
    | Annotated[NormOf, Tag("norm_of")]
    | Annotated[DiameterOf, Tag("diameter_of")]
    | Annotated[OdometryOf, Tag("odometry_of")]
    | Annotated[SpeedOf, Tag("speed_of")],
    by_key(
        DERIVED_KINDS,
        custom_error_type="derived",
        custom_error_message="expected a mapping with one of " + ", ".join(DERIVED_KINDS),
    ),
]
