"""Trace scripts: triggers to fire, or an event sequence, in order.

``pirate check --counterexamples`` writes files with an event sequence.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, model_validator

from pirate_sm.core._model.base import FaultCode, Frozen, Name
from pirate_sm.core._model.quantities import Duration


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
