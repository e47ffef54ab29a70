"""What shows that a command is done: the kinds of criteria, their numbers, and their words.

The thesis's robot could not distinguish "done" from "sent" (section 7-3-1). What sensors must show
for each kind is in ``core/_loading/robot/criteria.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees
from typing import Annotated, ClassVar, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from pirate_sm.core._model.base import Frozen, Name
from pirate_sm.core._model.quantities import (
    Angle,
    AngularSpeed,
    AnyQuantity,
    Duration,
    PositiveDuration,
    Ratio,
    Torque,
)
from pirate_sm.core._model.robot.body import Body
from pirate_sm.core.spelling import listed
from pirate_sm.core.units import ANGLE, format_quantity, in_degrees


def _lasting(for_s: float) -> str:
    return f", for {for_s:g} s" if for_s else ""


class DoneWhen(Frozen):
    """A kind of criterion: ``SHOWN`` is said where it has been met, ``LACKING`` where it is not."""

    SHOWN: ClassVar[str]
    LACKING: ClassVar[str]

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return in words when it is met; ``angles`` has the names of the angles by slot."""
        raise NotImplementedError


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
    settled: PositiveDuration | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if (self.at_least is None) != (self.settled is None):
            raise ValueError("`at_least` and `settled` need each other")
        return self

    def _or_weaker(self, besides: str = "") -> str:
        if self.settled is None or self.at_least is None:
            return ""
        return f", or more than {self.at_least:g} Nm{besides}{_lasting(self.settled)}"


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


class Accepted(DoneWhen):
    """Done as soon as the setpoints are accepted: there is nothing to measure.

    Attributes:
        kind: What shows that a command is done.
    """

    SHOWN: ClassVar[str] = "setpoints accepted"
    LACKING: ClassVar[str] = "its setpoints are not accepted"

    kind: Literal["accepted"]

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words."""
        return "its setpoints are accepted: no sensor shows more"


class Stalled(DoneWhen, Load):
    """Done when the joints stand still and each of ``loaded`` bears its torque for ``for``.

    Attributes:
        kind: What shows that a command is done.
        joints: Joints that must stand still, slower than ``still``.
        loaded: Joints that must bear the torque.
        still: The speed below which a joint stands still.
        end_stop: An apex nearer than this to its end stop is taken not to touch a wall.
        for_s: How long all of it must hold.
    """

    SHOWN: ClassVar[str] = "the joints stand still under torque"
    LACKING: ClassVar[str] = "the joints do not stand still under torque"

    kind: Literal["stalled"]
    joints: Annotated[tuple[Name, ...], Field(min_length=1)]
    loaded: Annotated[tuple[Name, ...], Field(min_length=1)]
    still: Annotated[AngularSpeed, Field(gt=0)]
    end_stop: Annotated[Angle, Field(ge=0)] = 0.0
    for_s: Annotated[Duration, Field(alias="for", ge=0)]

    def stops(self, body: Body) -> list[tuple[str, float]]:
        """Return each apex among the joints, and the angle that it must stay below, rad."""
        apexes = {part.apex for part in body.parts.values()}.intersection(self.joints)
        joints = [each for each in body.joints if each.name in apexes and self.end_stop]
        return [(each.name, each.end_stop - self.end_stop) for each in joints]

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words."""
        stand = "stands" if len(self.joints) == 1 else "stand"
        bear = "bears" if len(self.loaded) == 1 else "each bear"
        which = "" if self.loaded == self.joints else f"{listed(self.loaded)} "
        load = f"{(self.share or 0.0) * 100:g} % of what its motor gives at its duty"
        load = load if self.torque is None else f"{self.torque:g} Nm"
        apart = in_degrees(self.end_stop)
        off = f", an apex at least {apart} from its end stop" if self.end_stop else ""
        return (
            f"{listed(self.joints)} {stand} still, slower than {in_degrees(self.still)}/s{off}, "
            f"and {which}{bear} more than {load}{_lasting(self.for_s)}"
            f"{self._or_weaker(' and what holds the robot there')}"
        )


class Reached(DoneWhen, Weak):
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

    SHOWN: ClassVar[str] = "every joint has come to its angle"
    LACKING: ClassVar[str] = "not every joint is at its angle or stopped by the wall"

    kind: Literal["reached"]
    or_still: Annotated[AngularSpeed, Field(gt=0)] | None = None
    loaded: Annotated[Ratio, Field(gt=0, le=1)] = 0.7
    moved: Annotated[Angle, Field(ge=0)] = 0.0
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words."""
        lasting = _lasting(self.for_s)
        if self.or_still is None:
            return f"{self.SHOWN}{lasting}"
        moved = f", once one of them has turned by {degrees(self.moved):.3g}°"
        return (
            f"{self.SHOWN}, or is stopped by the wall: pushed with {self.loaded * 100:g} % of its "
            f"stall torque and slower than {in_degrees(self.or_still)}/s{lasting}"
            f"{self._or_weaker()}{moved if self.moved else ''}"
        )


class Turning(DoneWhen):
    """Done when one of the driven wheels turns the way it is driven, fast enough.

    Attributes:
        kind: What shows that a command is done.
        share: The angular speed, as a share of what the slowest motor of a wheel does without load.
        above: The same as a speed, for a robot whose motors are not known.
    """

    SHOWN: ClassVar[str] = "a driven wheel turns"
    LACKING: ClassVar[str] = "no driven wheel turns"

    kind: Literal["turning"]
    share: Annotated[Ratio, Field(gt=0, lt=1)] | None = None
    above: Annotated[AngularSpeed, Field(gt=0)] | None = None

    @model_validator(mode="after")
    def _is_known(self) -> Self:
        if (self.share is None) == (self.above is None):
            raise ValueError("give either `share` or `above`")
        return self

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words."""
        fast = f"{(self.share or 0.0) * 100:g} % of its motor's speed without load"
        fast = fast if self.above is None else f"{self.above:g} rad/s"
        return f"a driven wheel turns the way it is driven, faster than {fast}"


class Stopped(DoneWhen):
    """Done when the wheels whose boards report turn slower than ``below`` for ``for``.

    At least one wheel of each part must report.

    Attributes:
        kind: What shows that a command is done.
        below: The angular speed.
        for_s: How long it must hold.
    """

    SHOWN: ClassVar[str] = "the wheels stand still"
    LACKING: ClassVar[str] = "the wheels are not seen to stand still"

    kind: Literal["stopped"]
    below: Annotated[AngularSpeed, Field(gt=0)]
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words."""
        slow = f"no wheel that can be heard turns faster than {self.below:g} rad/s"
        return f"{slow}{_lasting(self.for_s)}"


class Aligned(DoneWhen):
    """Done when the angle behind each of the slots is ``within`` its setpoint.

    Attributes:
        kind: What shows that a command is done.
        slots: The slots whose angles are compared.
        within: The largest difference to the setpoint.
        leaning: By how much a part that holds may turn sideways out of the axis of the pipe; in a
            slope this leaves the roll of a part that is levelled uncertain.
    """

    SHOWN: ClassVar[str] = "the angle is at its setpoint"
    LACKING: ClassVar[str] = "the angle is not at its setpoint"

    kind: Literal["aligned"]
    slots: Annotated[tuple[Name, ...], Field(min_length=1)]
    within: Annotated[Angle, Field(gt=0)]
    leaning: Annotated[Angle, Field(ge=0)] = 0.0

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words, with the name of the angle of each slot."""
        names = listed(angles[name] for name in self.slots)
        return f"{names} is within {in_degrees(self.within)} of its setpoint"


class Below(DoneWhen):
    """Done when all the signals are smaller than ``limit`` in magnitude for ``for``.

    Attributes:
        kind: What shows that a command is done.
        signals: The signals that are compared.
        limit: The largest magnitude.
        for_s: How long it must hold.
    """

    SHOWN: ClassVar[str] = "near zero"
    LACKING: ClassVar[str] = "the signals are not near zero"

    kind: Literal["below"]
    signals: Annotated[tuple[Name, ...], Field(min_length=1)]
    limit: AnyQuantity
    for_s: Annotated[Duration, Field(alias="for", ge=0)] = 0.0

    def in_words(self, angles: Mapping[str, str]) -> str:
        """Return when it is met, in words."""
        limit = format_quantity(self.limit.value, self.limit.dimension)
        limit = in_degrees(self.limit.value) if self.limit.dimension == ANGLE else limit
        return f"{listed(self.signals)} are within {limit} of zero{_lasting(self.for_s)}"


Criterion: TypeAlias = Annotated[
    Accepted | Stalled | Reached | Turning | Stopped | Aligned | Below, Field(discriminator="kind")
]
