"""The catalogue of finding codes: what each means, why it matters and how to fix it.

The entries are in the YAML files in this folder, one file for each group.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Literal

from pirate_sm.core.documents import read_document
from pirate_sm.core.fields import Frozen
from pirate_sm.core.loading import validate
from pirate_sm.core.spelling import nearest

_HERE = Path(__file__).parent
_FILES = (
    "missions",
    "geometry",
    "rehearsal",
    "names",
    "charts",
    "robots",
    "robot_sense",
    "pipes",
    "panels",
    "scenes",
    "campaigns",
    "form",
    "project",
)


class CodeEntry(Frozen):
    """The description of one code.

    Attributes:
        severity: The severity of its findings, unless the check could not decide.
        title: What is wrong, in one line.
        why: Why it matters.
        fix: How it is usually corrected.
        wrong: A short example with the fault.
        right: The same example without the fault.
        allowable: Whether a comment can allow it; None for the value of its group.
    """

    severity: Literal["error", "warning"]
    title: str
    why: str
    fix: str
    wrong: str
    right: str
    allowable: bool | None = None


class Group(Frozen):
    """A group of related codes.

    Attributes:
        group: Its title.
        about: A description of the group.
        decided_by: What shows whether there is such a fault.
        not_decided: What the check cannot know of it.
        allowable: Whether comments can allow them; not for faults that prevent the use of a file.
    """

    group: str
    about: str
    decided_by: str
    not_decided: str
    codes: dict[str, CodeEntry]
    allowable: bool = False


@cache
def groups() -> tuple[Group, ...]:
    """Return all groups with their entries, missions first."""
    files = [_HERE / f"{name}.yaml" for name in _FILES]
    return tuple(validate(read_document(file, file.name), Group) for file in files)


@cache
def entries() -> Mapping[str, CodeEntry]:
    """Return all entries by their codes."""
    return {code: entry for group in groups() for code, entry in group.codes.items()}


def entry_of(code: str) -> CodeEntry:
    """Return the entry of a code; for an unknown code, one that only contains the code."""
    return entries().get(code) or CodeEntry(
        severity="error", title=code, why="", fix="", wrong="", right=""
    )


def group_of(code: str) -> Group:
    """Return the group of a code that there is."""
    return next(group for group in groups() if code in group.codes)


def nearest_code(word: str) -> str | None:
    """Return the code that a misspelt one most likely means, None without a similar one."""
    return nearest(word, entries())


@cache
def allowable() -> frozenset[str]:
    """Return the codes that a comment with a reason can allow."""
    return frozenset(
        code
        for group in groups()
        for code, entry in group.codes.items()
        if (group.allowable if entry.allowable is None else entry.allowable)
    )
