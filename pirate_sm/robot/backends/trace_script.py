"""Trace scripts: a list of triggers to fire, or an event sequence.

``pirate check --counterexamples`` writes files with an event sequence.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Annotated, Literal, NamedTuple, TypeAlias

from pydantic import Field, StringConstraints, model_validator

from pirate_sm.core.documents import Document, Problems
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import SignalReport
from pirate_sm.core.expressions import EnumType
from pirate_sm.core.fields import Duration, FaultCode, Frozen, Name
from pirate_sm.core.loading import try_validate, validate
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.spelling import meant, one_of
from pirate_sm.core.units import QuantityError, read_quantity


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


class Script(NamedTuple):
    """A trace script; one of the two is empty.

    Attributes:
        entries: The triggers to fire.
        course: The event sequence.
    """

    entries: tuple[ScriptEntry, ...] = ()
    course: tuple[Happening, ...] = ()


class ResolvedHappening(NamedTuple):
    """A happening with its signals as an event; ``report`` is None without signals."""

    happening: Happening
    report: SignalReport | None


def read_script(document: Document) -> Script:
    """Return the script in a file.

    Raises:
        LoadError: The file has faults; holds all of them.
    """
    if isinstance(document.data, dict) and "course" in document.data:
        return Script(course=validate(document, Course).course)
    problems = Problems(document)
    if not isinstance(document.data, list):
        message = "expected a list of {phase: …, trigger: …, after: 1 s}, or an event sequence"
        problems.add("script.list", (), message)
        problems.raise_errors()
    entries = [
        try_validate(document, ScriptEntry, problems, (number,))
        for number in range(len(document.data))
    ]
    problems.raise_errors()
    return Script(tuple(entry for entry in entries if entry is not None))


def resolve_course(course: Sequence[Happening], robot: RobotSpec) -> tuple[ResolvedHappening, ...]:
    """Return the course with its signals resolved for this robot.

    Raises:
        UsageError: A signal is unknown to the robot, or its value does not fit.
    """
    return tuple(ResolvedHappening(each, _report(each, robot)) for each in course)


def _report(happening: Happening, robot: RobotSpec) -> SignalReport | None:
    if not happening.signals:
        return None
    numbers, words = [], []
    for name, value in happening.signals.items():
        kind = robot.vocabulary.with_changes.types.get(name)
        if kind is None or name in robot.regions:
            raise UsageError(f"the script has the signal '{name}': {_meant(name, robot)}")
        if isinstance(kind, EnumType):
            words.append((name, _word(name, str(value), kind)))
        elif value == UNKNOWN:
            numbers.append((name, nan))
        else:
            try:
                numbers.append((name, read_quantity(str(value), kind.dimension)))
            except QuantityError as error:
                raise UsageError(f"the script has {name}: {value}: {error}") from None
    return SignalReport(tuple(numbers), tuple(words))


def _word(name: str, value: str, kind: EnumType) -> str | None:
    if value == UNKNOWN:
        return None
    if value not in kind.values:
        raise UsageError(f"the script has {name}: {value}: expected {one_of(kind.values)}")
    return value


def _meant(name: str, robot: RobotSpec) -> str:
    known = [each for each in robot.vocabulary.with_changes.types if each not in robot.regions]
    return meant(name, known, "the robot has no such signal")
