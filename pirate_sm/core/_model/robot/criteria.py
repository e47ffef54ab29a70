"""Criteria of completed commands and of states before anything moves, and safety rules.

They are a closed set with all numbers in the profile. The thesis's robot could not distinguish
"done" from "sent" (section 7-3-1). A state that a person or a file declares is unconfirmed until
sensors show it.
"""

from __future__ import annotations

from math import radians
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from pirate_sm.core._model.base import Condition, Frozen, Name
from pirate_sm.core._model.quantities import (
    Angle,
    AngularSpeed,
    AnyQuantity,
    Count,
    Duration,
    PositiveDuration,
    PositiveLength,
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
    settled: PositiveDuration | None = None

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


class SafetyRule(Frozen):
    """A safety rule: a condition that must always or never hold, whatever a mission commands.

    Exactly one of ``always``, ``never`` and ``expect`` is given. Conditions see the state of each
    region, ``command`` (just accepted), ``clamps`` (parts that the states hold),
    ``confirmed_clamps`` and ``driven_wheels``.

    Attributes:
        rule: Name of the rule.
        always: A condition that must hold.
        never: A condition that must not hold.
        after: The rule applies once this has been true.
        expect: A condition that must become true in time after ``after``.
        within_steps: With ``expect``: how many commands may be accepted until it holds.
        why: What happens if the rule is broken.
        waived_by: The key of a mission that waives the rule, with a reason.
    """

    rule: Name
    always: Condition | None = None
    never: Condition | None = None
    after: Condition | None = None
    expect: Condition | None = None
    within_steps: Annotated[Count, Field(ge=1, le=1000)] | None = None
    why: str = ""
    waived_by: Literal["allow_unclamp"] | None = None

    @model_validator(mode="after")
    def _one_of_three(self) -> SafetyRule:
        if sum(each is not None for each in (self.always, self.never, self.expect)) != 1:
            raise ValueError("expected exactly one of `always`, `never` and `expect`")
        if (self.expect is None) != (self.within_steps is None):
            raise ValueError("`expect` and `within_steps` go together")
        if self.expect is not None and self.after is None:
            raise ValueError("`expect` needs `after`: what it is expected to follow")
        return self
