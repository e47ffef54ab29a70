"""Criteria of completed commands, as a closed set with all numbers in the profile.

The thesis's robot could not distinguish "done" from "sent" (section 7-3-1).
"""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from pirate_sm.core._model.base import Frozen, Name
from pirate_sm.core._model.quantities import (
    Angle,
    AngularSpeed,
    AnyQuantity,
    Duration,
    Ratio,
    Torque,
)


class Weak(Frozen):
    """A smaller torque that counts as well once joints have stood still for ``settled``.

    Motors differ from what is known of them: a motor that is driven for so long has wound its
    spring, and bears what it can.

    Attributes:
        at_least: Smallest torque that counts after ``settled``. A part must bear what holds the
            robot in the mission's pipe in any case.
        settled: How long joints must stand still that bear less than their share.
    """

    at_least: Annotated[Torque, Field(gt=0)] | None = None
    settled: Annotated[Duration, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if (self.at_least is None) != (self.settled is None):
            raise ValueError("`at_least` and `settled` need each other")
        return self


class Load(Weak):
    """The torque that joints bear which press on something.

    Attributes:
        share: Smallest torque of each joint, as a share of what its motor bears at its duty cycle.
        torque: The same as a torque, for a robot whose stall torque is not known.
    """

    share: Annotated[Ratio, Field(gt=0, lt=1)] | None = None
    torque: Annotated[Torque, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _is_known(self) -> Self:
        if (self.share is None) == (self.torque is None):
            raise ValueError("give either `share` or `torque`")
        return self


class Accepted(Frozen):
    """Done as soon as the setpoints are accepted: there is nothing to measure.

    Attributes:
        kind: What shows that a command is done.
    """

    kind: Literal["accepted"]


class Stalled(Load):
    """Done when the joints stand still and each of ``loaded`` bears its torque for ``for``.

    Attributes:
        kind: What shows that a command is done.
        joints: Joints that must stand still, slower than ``still``.
        loaded: Joints that must bear the torque.
        still: The speed below which a joint stands still.
        for_s: How long all of it must hold.
    """

    kind: Literal["stalled"]
    joints: Annotated[tuple[Name, ...], Field(min_length=1)]
    loaded: Annotated[tuple[Name, ...], Field(min_length=1)]
    still: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[Duration, Field(alias="for", ge=0)]


class Reached(Weak):
    """Done when each joint with a target angle is within its threshold.

    With ``or_still``, a joint that the wall has stopped counts as well: it is pushed and stands
    still for ``for``. It is pushed while it bears at least ``loaded`` of the stall torque at its
    duty cycle, in the direction of the push. A spring that still unwinds does not push. Where no
    joint has ``moved``, none was stopped by the wall: something holds them where they were.

    Attributes:
        kind: What shows that a command is done.
        or_still: The speed below which a pushed joint counts as stopped by the wall.
        loaded: Share of its stall torque that such a joint bears at least.
        moved: How far one of the joints must have turned before the wall can have stopped them.
        for_s: How long all of it must hold.
    """

    kind: Literal["reached"]
    or_still: Annotated[AngularSpeed, Field(gt=0)] | None = None
    loaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.7
    moved: Annotated[Angle, Field(ge=0)] = 0.0
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


class Turning(Frozen):
    """Done when one of the driven wheels turns the way it is driven, fast enough.

    Attributes:
        kind: What shows that a command is done.
        share: The angular speed, as a share of what the slowest motor of a wheel does without load.
        above: The same as a speed, for a robot whose motors are not known.
    """

    kind: Literal["turning"]
    share: Annotated[Ratio, Field(gt=0, lt=1)] | None = None
    above: Annotated[AngularSpeed, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _is_known(self) -> Self:
        if (self.share is None) == (self.above is None):
            raise ValueError("give either `share` or `above`")
        return self


class Stopped(Frozen):
    """Done when the wheels whose boards report turn slower than ``below`` for ``for``.

    At least one wheel of each part must report.

    Attributes:
        kind: What shows that a command is done.
        below: The angular speed.
        for_s: How long it must hold.
    """

    kind: Literal["stopped"]
    below: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


class Aligned(Frozen):
    """Done when the angle behind each of the slots is ``within`` its setpoint.

    Attributes:
        kind: What shows that a command is done.
        slots: The slots whose angles are compared.
        within: The largest difference to the setpoint.
        leaning: By how much a part that holds may turn sideways out of the axis of the pipe; in a
            slope this leaves the roll of a part that is levelled uncertain.
    """

    kind: Literal["aligned"]
    slots: Annotated[tuple[Name, ...], Field(min_length=1)]
    within: Annotated[Angle, Field(gt=0)]
    leaning: Annotated[Angle, Field(ge=0)] = 0.0


class Below(Frozen):
    """Done when all the signals are smaller than ``limit`` in magnitude for ``for``.

    Attributes:
        kind: What shows that a command is done.
        signals: The signals that are compared.
        limit: The largest magnitude.
        for_s: How long it must hold.
    """

    kind: Literal["below"]
    signals: Annotated[tuple[Name, ...], Field(min_length=1)]
    limit: AnyQuantity
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


Criterion: TypeAlias = Annotated[
    Accepted | Stalled | Reached | Turning | Stopped | Aligned | Below, Field(discriminator="kind")
]
