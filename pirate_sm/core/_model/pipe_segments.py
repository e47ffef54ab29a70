"""The segments of a pipe: straights, fittings, and tees between them."""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field, Tag

from pirate_sm.core._geometry import network as space
from pirate_sm.core._model.base import Frozen, by_key
from pirate_sm.core._model.quantities import Angle, Length, range_fault
from pirate_sm.core._model.simulation import Coefficients

_ROUNDING_DEG = 1e-6


def within(limit_deg: int) -> AfterValidator:
    """Return a validator of angles up to a limit in either direction."""

    def check(angle_rad: float) -> float:
        angle_deg = math.degrees(angle_rad)
        if abs(angle_deg) <= limit_deg + _ROUNDING_DEG:
            return angle_rad
        bound = f"at most {limit_deg}" if angle_deg > 0 else f"at least -{limit_deg}"
        raise range_fault(f"expected {bound} deg, got {angle_deg:.6g} deg")

    return AfterValidator(check)


def _square(angle_rad: float) -> float:
    """Return the angle of a tee; raise ValueError unless it is a right angle."""
    if abs(math.degrees(angle_rad) - 90) > _ROUNDING_DEG:
        raise range_fault(f"expected 90 deg, got {math.degrees(angle_rad):.6g} deg")
    return angle_rad


TeeAngle = Annotated[Angle, AfterValidator(_square)]
"""The angle of a tee, between its run and its branch; 90 deg."""

Roll = Annotated[Angle, within(180)]


class Straight(Frozen):
    """A straight of this length, measured along the axis to the intersection of the axes.

    Attributes:
        straight: Its length, measured along the axis to the intersection of the axes.
        friction: Friction of its wall; overrides that of the pipe.
    """

    straight: Annotated[Length, Field(gt=0, le=100)]
    friction: Coefficients | None = None

    def in_space(self) -> space.Straight:
        """Return it as geometry."""
        return space.Straight(self.straight)


class Mitre(Frozen):
    """A mitre bend by this angle; positive turns to side A of the robot in normal polarity.

    Attributes:
        mitre: Its angle, at most 120 deg in either direction; positive turns to side A of the robot
            in normal polarity.
        roll: Roll of its plane about the direction of travel, in a round pipe: 0 deg turns towards
            side A, 90 deg turns up where the run is flat.
    """

    mitre: Annotated[Angle, within(120)]
    roll: Roll = 0.0

    def in_space(self) -> space.Mitre:
        """Return it as geometry."""
        return space.Mitre(self.mitre, self.roll)


class Elbow(Frozen):
    """A bend by this angle along an arc, in a round pipe.

    Attributes:
        elbow: Its angle, at most 180 deg in either direction; positive turns to side A.
        radius: Radius of its centre line; at least half the diameter.
        roll: Roll of its plane about the direction of travel.
        friction: Friction of its wall; overrides that of the pipe.
    """

    elbow: Annotated[Angle, within(180)]
    radius: Annotated[Length, Field(gt=0, le=100)]
    roll: Roll = 0.0
    friction: Coefficients | None = None

    def in_space(self) -> space.Elbow:
        """Return it as geometry."""
        return space.Elbow(self.elbow, self.radius, self.roll)


class Reducer(Frozen):
    """A cone of this length to another diameter, in a round pipe; a length of 0 is a step.

    Attributes:
        reducer: Its length.
        to: Inner diameter behind it.
        friction: Friction of its wall; overrides that of the pipe.
    """

    reducer: Annotated[Length, Field(ge=0, le=100)]
    to: Annotated[Length, Field(gt=0, le=10)]
    friction: Coefficients | None = None

    def in_space(self) -> space.Reducer:
        """Return it as geometry."""
        return space.Reducer(self.reducer, self.to)


class InlineTee(Frozen):
    """A tee in a list of segments, which goes on in its branch or straight on.

    Attributes:
        tee: Angle between its run and its branch; 90 deg.
        roll: Direction of the branch about the direction of travel: 0 deg is towards side A, 90 deg
            is up where the run is flat.
        take: Which of its arms the following segments are; the other is a closed stub.
        stub: Length of the stub, from the intersection of the axes.
        diameter: Inner diameter of the branch; by default that of the run.
    """

    tee: TeeAngle
    roll: Roll = 0.0
    take: Literal["branch", "on"]
    stub: Annotated[Length, Field(gt=0, le=100)] = 0.5
    diameter: Annotated[Length, Field(gt=0, le=10)] | None = None


_Straight: TypeAlias = Annotated[Straight, Tag("straight")]
_Mitre: TypeAlias = Annotated[Mitre, Tag("mitre")]
_Elbow: TypeAlias = Annotated[Elbow, Tag("elbow")]
_Reducer: TypeAlias = Annotated[Reducer, Tag("reducer")]

Segment: TypeAlias = Annotated[
    _Straight | _Mitre | _Elbow | _Reducer,
    by_key(
        ("straight", "mitre", "elbow", "reducer"),
        custom_error_type="segment",
        custom_error_message="expected a segment, {straight: 1.0 m}, {mitre: 90 deg},"
        " {elbow: 90 deg, radius: 180 mm} or {reducer: 60 mm, to: 100 mm}",
    ),
]
"""A segment of a run."""

SegmentOrTee: TypeAlias = Annotated[
    _Straight | _Mitre | _Elbow | _Reducer | Annotated[InlineTee, Tag("tee")],
    by_key(
        ("straight", "mitre", "elbow", "reducer", "tee"),
        custom_error_type="segment",
        custom_error_message="expected a segment, {straight: 1.0 m}, {mitre: 90 deg},"
        " {elbow: 90 deg, radius: 180 mm}, {reducer: 60 mm, to: 100 mm} or"
        " {tee: 90 deg, take: branch}",
    ),
]
"""A segment of a pipe without runs."""
