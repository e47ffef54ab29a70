"""Criteria that show that a command is done: a closed set, all numbers in the profile.

"Done" is what the thesis's robot could not tell from "sent" (section 7-3-1).
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import Angle, AngularSpeed, AnyQuantity, Duration, Ratio, Torque


class Accepted(Frozen):
    """Done as soon as the setpoints are accepted: there is nothing to measure.

    Attributes:
        kind: What shows that a command is done.
    """

    kind: Literal["accepted"]


class Stalled(Frozen):
    """Done when the joints stand still and each of ``loaded`` bears ``torque`` during ``for``.

    Attributes:
        kind: What shows that a command is done.
        joints: Joints that must stand still, slower than ``still``.
        loaded: Joints that must bear the torque.
        torque: The torque that each of ``loaded`` must bear.
        still: The speed below which a joint stands still.
        for_s: How long all of it must hold.
    """

    kind: Literal["stalled"]
    joints: Annotated[tuple[Name, ...], Field(min_length=1)]
    loaded: Annotated[tuple[Name, ...], Field(min_length=1)]
    torque: Annotated[Torque, Field(gt=0)]
    still: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[Duration, Field(alias="for", ge=0)]


class Reached(Frozen):
    """Done when each joint with an angle to come to is inside its threshold.

    Where ``or_still`` is given, a joint that is pushed and stands still for as long as ``for``
    counts as well: the wall has stopped it. It is pushed while it bears ``loaded`` of the torque
    that its duty cycle gives at stall, in the direction of the push; a spring that still unwinds
    does not.

    Attributes:
        kind: What shows that a command is done.
        or_still: A joint that is pushed and slower than this has been stopped by the wall, and
            counts.
        loaded: Share of its stall torque that such a joint bears.
        for_s: How long all of it must hold.
    """

    kind: Literal["reached"]
    or_still: Annotated[AngularSpeed, Field(gt=0)] | None = None
    loaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.7
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


class Turning(Frozen):
    """Done when one of the driven wheels turns the way it is driven, faster than ``above``.

    Attributes:
        kind: What shows that a command is done.
        above: The angular speed.
    """

    kind: Literal["turning"]
    above: Annotated[AngularSpeed, Field(gt=0)]


class Stopped(Frozen):
    """Done when the wheels that can be heard turn slower than ``below``, for as long as ``for``.

    Of each part at least one wheel must be heard.

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
        slots: The slots whose angles are looked at.
        within: The largest difference to the setpoint.
    """

    kind: Literal["aligned"]
    slots: Annotated[tuple[Name, ...], Field(min_length=1)]
    within: Annotated[Angle, Field(gt=0)]


class Below(Frozen):
    """Done when all the signals are smaller than ``limit`` in magnitude, for as long as ``for``.

    Attributes:
        kind: What shows that a command is done.
        signals: The signals that are looked at.
        limit: The largest magnitude.
        for_s: How long it must hold.
    """

    kind: Literal["below"]
    signals: Annotated[tuple[Name, ...], Field(min_length=1)]
    limit: AnyQuantity
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0


Criterion: TypeAlias = Annotated[
    Accepted | Stalled | Reached | Turning | Stopped | Aligned | Below,
    Field(discriminator="kind"),
]
