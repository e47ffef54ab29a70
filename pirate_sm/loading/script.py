"""A trace script, read from a file: a list of triggers to take, or a course of events."""

from __future__ import annotations

from typing import NamedTuple

from pirate_sm.loading.course import read_course
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.source import Document
from pirate_sm.loading.validate import try_validate
from pirate_sm.model.course import Happening
from pirate_sm.model.script import ScriptEntry


class Script(NamedTuple):
    """What a trace script says; one of the two is empty.

    Attributes:
        entries: The triggers that it lists.
        course: The course of events that it lays down.
    """

    entries: tuple[ScriptEntry, ...] = ()
    course: tuple[Happening, ...] = ()


def read_script(document: Document) -> Script:
    """The script that a file holds.

    Raises:
        LoadError: Everything that is wrong with it.
    """
    if isinstance(document.data, dict) and "course" in document.data:
        return Script(course=read_course(document))
    problems = Problems(document)
    if not isinstance(document.data, list):
        message = "expected a list of {phase: …, trigger: …, after: 1 s}, or a course of events"
        problems.add("script.list", (), message)
        problems.raise_errors()
    entries = [
        try_validate(document, ScriptEntry, problems, (number,))
        for number in range(len(document.data))
    ]
    problems.raise_errors()
    return Script(tuple(entry for entry in entries if entry is not None))
