"""Every code that a finding can have: what it means, why it matters and how it is mended.

The entries stand in the YAML files beside this one, a file for each group.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Literal

from pirate_sm.loading.yaml.document import read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model.base import Frozen
from pirate_sm.spelling import nearest

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
    "form",
    "project",
)


class Entry(Frozen):
    """What is to be known of one code.

    Attributes:
        severity: The one that its findings have unless the check could not decide.
        title: What is wrong, in one line.
        why: Why it matters.
        mend: How it is usually mended.
        wrong: A short example of it.
        right: The same without the fault.
        allowable: Whether a comment can allow it; None: as its group says.
    """

    severity: Literal["error", "warning"]
    title: str
    why: str
    mend: str
    wrong: str
    right: str
    allowable: bool | None = None


class Group(Frozen):
    """Codes that belong together.

    Attributes:
        group: Its title.
        about: What they have in common.
        allowable: Whether comments can allow them: not what keeps a file from being used.
    """

    group: str
    about: str
    codes: dict[str, Entry]
    allowable: bool = False


@cache
def groups() -> tuple[Group, ...]:
    """Return every group with its entries, those of missions first."""
    files = [_HERE / f"{name}.yaml" for name in _FILES]
    return tuple(validate(read_document(file, file.name), Group) for file in files)


@cache
def entries() -> Mapping[str, Entry]:
    """Return every entry by its code."""
    return {code: entry for group in groups() for code, entry in group.codes.items()}


def entry_of(code: str) -> Entry:
    """Return the entry of a code; where there is none, one that only names the code."""
    return entries().get(code) or Entry(
        severity="error", title=code, why="", mend="", wrong="", right=""
    )


def nearest_code(word: str) -> str | None:
    """Return the code that a misspelt one most likely stands for, if one is close."""
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
