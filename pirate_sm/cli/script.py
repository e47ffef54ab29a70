"""What a trace shall fire: from the command line, or from a YAML file."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from pathlib import Path
from typing import Annotated

from pydantic import Field

from pirate_sm.errors import UsageError
from pirate_sm.loading.course import read_course
from pirate_sm.loading.problems import Problems
from pirate_sm.loading.source import read_document
from pirate_sm.loading.validate import try_validate
from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.course import Happening
from pirate_sm.model.quantities import Duration
from pirate_sm.runtime.companions import Firing


class ScriptEntry(Frozen):
    """In a wait (of ``phase``, if given) that has the trigger, take it ``after`` so long."""

    trigger: Name
    after: Annotated[Duration, Field(ge=0)] | None = None
    phase: str = ""


def read_fire(texts: Iterable[str]) -> list[Firing]:
    """The firings that ``--fire TRIGGER[=SECONDS]`` asks for.

    Raises:
        UsageError: One of them reads otherwise.
    """
    firings = []
    for text in texts:
        trigger, given, after = text.partition("=")
        firings.append(Firing(trigger, _seconds(after, text) if given else None))
    return firings


def _seconds(text: str, whole: str) -> float:
    try:
        after_s = float(text.strip().removesuffix("s"))
    except ValueError:
        after_s = -1.0
    if not (isfinite(after_s) and after_s >= 0):
        raise UsageError(f"--fire {whole}: expected TRIGGER or TRIGGER=SECONDS, such as past=2.5")
    return after_s


def read_script(path: Path) -> tuple[list[Firing], tuple[Happening, ...]]:
    """The firings that a file lists, or the whole course of events that it lays down.

    Raises:
        LoadError: Everything that is wrong with the file.
    """
    document = read_document(path)
    if isinstance(document.data, dict) and "course" in document.data:
        return [], read_course(document)
    problems = Problems(document)
    firings = []
    if not isinstance(document.data, list):
        problems.add(
            "script.list",
            (),
            "expected a list of {phase: …, trigger: …, after: 1 s}, or a course of events",
        )
        problems.raise_errors()
    for number in range(len(document.data)):
        entry = try_validate(document, ScriptEntry, problems, (number,))
        if entry is not None:
            firings.append(Firing(entry.trigger, entry.after, entry.phase))
    problems.raise_errors()
    return firings, ()
