"""Read trace scripts: a list of triggers to fire, or an event sequence."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import NamedTuple

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._expressions import EnumType
from pirate_sm.core._loading.problems import Problems
from pirate_sm.core._loading.yaml.document import Document
from pirate_sm.core._loading.yaml.validation import try_validate, validate
from pirate_sm.core._model.events import SignalReport
from pirate_sm.core._model.triggers import UNKNOWN, Course, Happening, ScriptEntry
from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import meant, one_of
from pirate_sm.core.units import QuantityError, read_quantity


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
