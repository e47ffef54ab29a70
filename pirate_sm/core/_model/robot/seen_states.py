"""How sensors show the states of a robot and its held parts before anything moves.

A declared state is unconfirmed until sensors show it.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from pirate_sm.core._model.base import Frozen, Name
from pirate_sm.core._model.quantities import (
    Angle,
    AngularSpeed,
    PositiveDuration,
    PositiveLength,
    Ratio,
    Torque,
)
from pirate_sm.core._model.robot.done_criteria import Load, Stopped, Turning


class HeldPart(Load):
    """Criterion of a held part without actuation.

    Confirmed: each of ``loaded`` bears its torque on its spring, in the direction in which the
    state turns it, and stands still, and the part shows the diameter of the pipe. Contradicted:
    none of ``loaded`` bears ``slack``, or the diameter differs too much. Without a known pipe, the
    diameter must be within the part's reach and match the other held parts.

    Attributes:
        loaded: Joints that bear the torque of the clamp.
        slack: A part does not hold if all its loaded joints bear less than this. A part that spans
            a known pipe and presses by this much at its apex may hold, even where none should.
        still: The speed below which a joint stands still.
        span: Largest relative difference from the pipe's diameter.
        span_off: Smallest relative difference at which the part does not hold in this pipe.
        end_stop: A part touches no wall if its apex is nearer than this to its end stop.
        for_s: How long all of it must last.
    """

    loaded: Annotated[tuple[Name, ...], Field(min_length=1)]
    slack: Annotated[Torque, Field(gt=0)]
    still: Annotated[AngularSpeed, Field(gt=0)]
    span: Annotated[Ratio, Field(gt=0, lt=1)]
    span_off: Annotated[Ratio, Field(gt=0, lt=1)]
    end_stop: Annotated[Angle, Field(gt=0)]
    for_s: Annotated[PositiveDuration, Field(alias="for")]


class Angles(Frozen):
    """Confirmed while every angle that the state sets is ``within`` its setpoint.

    Attributes:
        kind: How the state shows itself.
        within: The largest difference to the setpoint.
        beyond: Smallest difference that contradicts the state; without it, none does.
        for_s: How long it must last.
    """

    kind: Literal["angles"]
    within: Annotated[Angle, Field(gt=0)]
    beyond: Annotated[Angle, Field(gt=0)] | None = None
    for_s: Annotated[PositiveDuration, Field(alias="for")]


class StandingWheels(Stopped):
    """Confirmed while the region's reporting wheels, at least one, stand still.

    Contradicted while one of them turns.

    Attributes:
        for_s: How long it must last.
    """

    for_s: Annotated[PositiveDuration, Field(alias="for")]


class TurningWheels(Turning):
    """Never confirmed; contradicted while a wheel turns against its setpoint.

    Wheels that stand still or turn as commanded count as driven only after a command.

    Attributes:
        for_s: How long it must last.
    """

    for_s: Annotated[PositiveDuration, Field(alias="for")]


class AcceptedState(Frozen):
    """Confirmed as soon as setpoints for the state are accepted; nothing is measured.

    Attributes:
        kind: How the state shows itself.
        why: Why there is nothing to measure.
    """

    kind: Literal["accepted"]
    why: Annotated[str, Field(min_length=1)]


class Implied(Frozen):
    """Confirmed by the held parts alone; the state adds no condition of its own.

    Attributes:
        kind: How the state shows itself.
        why: The reason.
    """

    kind: Literal["implied"]
    why: Annotated[str, Field(min_length=1)]


class Unknown(Frozen):
    """No sensor shows the state; it is unconfirmed until a command confirms it.

    Attributes:
        kind: How the state shows itself.
        why: Why no sensor shows it.
    """

    kind: Literal["unknown"]
    why: Annotated[str, Field(min_length=1)]


SeenState: TypeAlias = Annotated[
    Angles | StandingWheels | TurningWheels | AcceptedState | Implied | Unknown,
    Field(discriminator="kind"),
]


class Seen(Frozen):
    """All criteria by which sensors confirm states and held parts before the first command.

    Attributes:
        within: Longest duration of the comparison.
        wheels_agree: After a crash the way rolled meanwhile is known if all wheels with an
            ``absolute`` angle agree on it within this.
        tilt: A robot at rest whose direction of gravity has changed by more since the recording
            was cut off is not where it was.
        joint_off: A loaded joint of a part that was clamped and at rest has moved if its angle
            has changed by more since then.
        parts: The criterion of each part.
        states: The criterion of each state of each region.
    """

    within: PositiveDuration = 1.0
    wheels_agree: PositiveLength = 0.003
    tilt: Annotated[Angle, Field(gt=0)] = radians(15)
    joint_off: Annotated[Angle, Field(gt=0)] = radians(5)
    parts: dict[Name, HeldPart] = {}
    states: dict[Name, dict[Name, SeenState]] = {}
