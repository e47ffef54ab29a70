"""How it is seen that a command is done: a closed set of kinds, all numbers in the profile.

"Done" is what the thesis's robot could not tell from "sent" (section 7-3-1).
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import Angle, AngularSpeed, AnyQuantity, Duration, Ratio, Torque


class Accepted(Frozen):
    """Done as soon as the setpoints are accepted: there is nothing to measure."""

    kind: Literal["accepted"]


class Stalled(Frozen):
    """Done when the joints stand still and each of ``loaded`` bears ``torque``, ``for`` so long.

    Attributes:
        joints: Joints that must stand still, slower than ``still``.
        loaded: Joints that must bear the torque.
    """

    kind: Literal["stalled"]
    joints: Annotated[tuple[Name, ...], Field(min_length=1)]
    loaded: Annotated[tuple[Name, ...], Field(min_length=1)]
    torque: Annotated[Torque, Field(gt=0)]
    still: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[Duration, Field(alias="for", ge=0)]


class Reached(Frozen):
    """Done when each joint with an angle to come to is inside its threshold.

    Where ``or_still`` is given, a joint that stands still for ``for`` so long while pushed counts
    as well: the wall has stopped it. It is pushed while it bears ``loaded`` of the torque that its
    duty cycle gives at stall, in the direction of the push; a spring that still unwinds does not.
    """

    kind: Literal["reached"]
    or_still: Annotated[AngularSpeed, Field(gt=0)] | None = None
    loaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.7
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


class Turning(Frozen):
    """Done when one of the driven wheels turns faster than ``above``."""

    kind: Literal["turning"]
    above: Annotated[AngularSpeed, Field(gt=0)]


class Stopped(Frozen):
    """Done when no wheel that can be measured turns faster than ``below``, ``for`` so long."""

    kind: Literal["stopped"]
    below: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


class Aligned(Frozen):
    """Done when the angle behind each of the slots is ``within`` its setpoint."""

    kind: Literal["aligned"]
    slots: Annotated[tuple[Name, ...], Field(min_length=1)]
    within: Annotated[Angle, Field(gt=0)]


class Below(Frozen):
    """Done when all the signals are smaller than ``limit`` in magnitude, ``for`` so long."""

    kind: Literal["below"]
    signals: Annotated[tuple[Name, ...], Field(min_length=1)]
    limit: AnyQuantity
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


Criterion: TypeAlias = Annotated[
    Accepted | Stalled | Reached | Turning | Stopped | Aligned | Below,
    Field(discriminator="kind"),
]
