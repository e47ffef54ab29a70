"""Triggers of waits (a condition, a time, the operator's answer), and scripts that fire them.

A script lists triggers to fire, or an event sequence. ``pirate check --counterexamples`` writes
files with an event sequence.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core._model.base import Condition, FaultCode, Frozen, Name, by_key
from pirate_sm.core._model.quantities import Duration, DurationOrParameter


class ConditionTrigger(Frozen):
    """Fires when the condition has been true for ``held``.

    Attributes:
        when: The condition.
        held: How long it must have been true without interruption.
        go: The target phase or end; optional in a step, for the next step.
        name: Its name in views, recordings and ``--fire``; by default the target.
    """

    when: Condition
    held: DurationOrParameter = 0.0
    go: Name | None = None
    name: Name | None = None


class TimeTrigger(Frozen):
    """Fires when this much time has passed since the wait was armed.

    Attributes:
        after: Time since the wait began.
        go: The target phase or end; optional in a step, for the next step.
        name: Its name in views, recordings and ``--fire``; by default the target.
    """

    after: DurationOrParameter
    go: Name | None = None
    name: Name | None = None


class OperatorTrigger(Frozen):
    """Fires when the operator gives this answer.

    Attributes:
        operator: The answer, as shown to the operator.
        go: The target phase or end; optional in a step, for the next step.
        name: Its name in views, recordings and ``--fire``; by default the target.
    """

    operator: Name
    go: Name | None = None
    name: Name | None = None


Trigger: TypeAlias = Annotated[
    Annotated[ConditionTrigger, Tag("when")]
    | Annotated[TimeTrigger, Tag("after")]
    | Annotated[OperatorTrigger, Tag("operator")],
    by_key(
        ("when", "after", "operator"),
        custom_error_type="trigger",
        custom_error_message="expected a trigger: a mapping with one of when, after, operator",
    ),
]


class Within(Frozen):
    """The time limit of a wait, and the target after it.

    Attributes:
        time: The time limit.
        go: The target phase or end; optional in a step, which then fails.
    """

    time: DurationOrParameter
    go: Name | None = None


class ScriptEntry(Frozen):
    """Fires the trigger after the time ``after``, in the next wait (of ``phase``) that has it."""

    trigger: Name
    after: Annotated[Duration, Field(ge=0)] | None = None
    phase: str = ""


UNKNOWN = "unknown"


SignalName: TypeAlias = Annotated[
    str, StringConstraints(pattern=r"^([A-Za-z_][A-Za-z0-9_]*|change\([A-Za-z_][A-Za-z0-9_]*\))$")
]
"""A signal, or its change since a wait began."""


class Happening(Frozen):
    """One event of a course.

    Attributes:
        happens: ``accepted`` and ``rejected``: the result of the setpoints in flight. ``time``: the
            next deadline, at which a command counts as done. ``not_done``: the command under way
            fails. ``sensors``: the signals change. ``answer`` of the operator. ``fault``.
        signals: The signals and words from then on: quantities, words, or ``unknown``.
        message: Message of a fault. With a rule's message the fault counts as raised by that rule.
        of: The boards, joints, wheels and parts that it is a fault of.
        what: A description of the event in the mission, for readers.
    """

    happens: Literal[
        "start", "accepted", "rejected", "time", "not_done", "sensors", "answer", "fault"
    ]
    signals: dict[SignalName, str | int | float] = {}
    answer: str | None = None
    fault: FaultCode | None = None
    message: str = ""
    of: tuple[Name, ...] = ()
    what: str = ""

    @model_validator(mode="after")
    def _complete(self) -> Happening:
        for key in ("answer", "fault"):
            if (getattr(self, key) is not None) != (self.happens == key):
                raise ValueError(f"`{key}` says what happens where `happens: {key}`, only there")
        for key in ("message", "of"):
            if getattr(self, key) and self.fault is None:
                raise ValueError(f"`{key}` is that of a fault, only with `happens: fault`")
        return self


class Course(Frozen):
    """An event sequence from the start of a mission; after it, everything succeeds."""

    format: Literal[1]
    course: Annotated[tuple[Happening, ...], Field(min_length=1)]
