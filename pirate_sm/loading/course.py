"""A course of events, read from a file and told in the terms of a robot."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import NamedTuple

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.errors import UsageError
from pirate_sm.expressions import EnumType
from pirate_sm.loading.source import Document
from pirate_sm.loading.validate import validate
from pirate_sm.model.course import UNKNOWN, Course, Happening
from pirate_sm.model.events import SignalReport
from pirate_sm.spelling import nearest, one_of
from pirate_sm.units import QuantityError, read_quantity


class Told(NamedTuple):
    """A happening as the engine is told it; ``report`` is None where no sensor shows anything."""

    happening: Happening
    report: SignalReport | None


def read_course(document: Document) -> tuple[Happening, ...]:
    """The course that a file lays down.

    Raises:
        LoadError: Everything that is wrong with it.
    """
    return validate(document, Course).course


def played(course: Sequence[Happening], robot: RobotSpec) -> tuple[Told, ...]:
    """The course with its signals as this robot knows them.

    Raises:
        UsageError: It has a signal that the robot does not have, or a value that does not fit.
    """
    return tuple(Told(each, _report(each, robot)) for each in course)


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
    close = nearest(name, known)
    return f"did you mean '{close}'?" if close else "the robot has no such signal"
