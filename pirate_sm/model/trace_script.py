"""Trace scripts: triggers to take, or a course of events, in order.

Files with a course are written by ``pirate check --counterexamples``, or by hand.
"""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, model_validator

from pirate_sm.model.base import FaultCode, Frozen, Name
from pirate_sm.model.quantities import Duration


class ScriptEntry(Frozen):
    """In a wait (of ``phase``, if given) that has the trigger, take it after the time ``after``."""

    trigger: Name
    after: Annotated[Duration, Field(ge=0)] | None = None
    phase: str = ""


UNKNOWN = "unknown"


SignalName: TypeAlias = Annotated[
    str, StringConstraints(pattern=r"^([A-Za-z_][A-Za-z0-9_]*|change\([A-Za-z_][A-Za-z0-9_]*\))$")
]
"""A signal, or its change since a wait began."""


class Happening(Frozen):
    """One thing that happens.

    Attributes:
        happens: ``accepted`` and ``rejected``: to the setpoints that are under way; ``time``: the
            next deadline comes, at which a command counts as done; ``not_done``: the command
            under way fails; ``sensors``: they show something else; ``answer`` and ``fault``.
        signals: What sensors and detector show from then on: quantities, words, ``unknown``.
        message: Of a fault; that of one of the robot's rules makes it that rule's.
        what: For people: what this is in the mission.
    """

    happens: Literal[
        "start", "accepted", "rejected", "time", "not_done", "sensors", "answer", "fault"
    ]
    signals: dict[SignalName, str | int | float] = {}
    answer: str | None = None
    fault: FaultCode | None = None
    message: str = ""
    what: str = ""

    @model_validator(mode="after")
    def _complete(self) -> Happening:
        for key in ("answer", "fault"):
            if (getattr(self, key) is not None) != (self.happens == key):
                raise ValueError(f"`{key}` says what happens where `happens: {key}`, only there")
        if self.message and self.fault is None:
            raise ValueError("`message` is that of a fault, only with `happens: fault`")
        return self


class Course(Frozen):
    """What happens to a mission, from its start on; then everything goes well."""

    format: Literal[1]
    course: Annotated[tuple[Happening, ...], Field(min_length=1)]
