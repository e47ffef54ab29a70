"""How sensors show a state before anything moves: confirmed, contradicted, or unknown.

A state that a person or a file declares is not confirmed by that ("said is not seen").
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import Angle, AngularSpeed, Duration, Ratio, Torque

PositiveDuration = Annotated[Duration, Field(gt=0)]


class HeldPart(Frozen):
    """How a held part shows itself while nobody actuates it.

    Confirmed: each of ``loaded`` bears ``torque`` on its spring, in the direction in which the
    state turns it, and stands still, and the diameter that the part shows is that of the pipe.
    Contradicted: none of ``loaded`` bears ``slack``, or the diameter is too far off. Where no pipe
    is known, the diameter must be within the part's reach and that of the other held parts.

    Attributes:
        loaded: Joints that bear the torque of the clamp.
        torque: What each of them bears at least when the part holds.
        slack: A part of which every loaded joint bears less than this does not hold.
        still: The speed below which a joint stands still.
        span: Largest difference to the diameter of the pipe, as a share of it.
        span_off: From this difference on the part does not hold in this pipe.
        end_stop: A part whose apex is nearer than this to its end stop touches no wall.
        for_s: How long all of it must last.
    """

    loaded: Annotated[tuple[Name, ...], Field(min_length=1)]
    torque: Annotated[Torque, Field(gt=0)]
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
        beyond: From this difference on the state is contradicted; without it never.
        for_s: How long it must last.
    """

    kind: Literal["angles"]
    within: Annotated[Angle, Field(gt=0)]
    beyond: Annotated[Angle, Field(gt=0)] | None = None
    for_s: Annotated[PositiveDuration, Field(alias="for")]


class StandingWheels(Frozen):
    """Confirmed while the wheels of the region that can be heard, at least one, stand still.

    Contradicted while one turns.

    Attributes:
        kind: How the state shows itself.
        below: The speed below which a wheel stands still.
        for_s: How long it must last.
    """

    kind: Literal["stopped"]
    below: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[PositiveDuration, Field(alias="for")]


class TurningWheels(Frozen):
    """Never confirmed; contradicted while a wheel turns against its setpoint.

    Wheels that stand still, or turn the commanded way, are driven only when a command drives them.

    Attributes:
        kind: How the state shows itself.
        above: The speed from which on a wheel turns.
        for_s: How long it must last.
    """

    kind: Literal["turning"]
    above: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[PositiveDuration, Field(alias="for")]


class Accepted(Frozen):
    """Confirmed as soon as setpoints that hold the state have been accepted; nothing to measure.

    Attributes:
        kind: How the state shows itself.
        why: Why there is nothing to measure.
    """

    kind: Literal["accepted"]
    why: Annotated[str, Field(min_length=1)]


class Implied(Frozen):
    """The state says nothing that could be wrong beyond what its held parts show.

    Attributes:
        kind: How the state shows itself.
        why: Why that is so.
    """

    kind: Literal["implied"]
    why: Annotated[str, Field(min_length=1)]


class Unknown(Frozen):
    """No sensor shows the state; it is unconfirmed until a command has made it.

    Attributes:
        kind: How the state shows itself.
        why: Why no sensor shows it.
    """

    kind: Literal["unknown"]
    why: Annotated[str, Field(min_length=1)]


SeenState: TypeAlias = Annotated[
    Angles | StandingWheels | TurningWheels | Accepted | Implied | Unknown,
    Field(discriminator="kind"),
]


class Seen(Frozen):
    """How states and held parts show themselves to the sensors before the first command.

    Attributes:
        within: How long the sensors are compared with what is declared, at most.
        parts: Per part how it shows that it is held.
        states: Per region and state how it shows itself.
    """

    within: PositiveDuration = 1.0
    parts: dict[Name, HeldPart] = {}
    states: dict[Name, dict[Name, SeenState]] = {}
