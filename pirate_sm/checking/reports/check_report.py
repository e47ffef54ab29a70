"""The result of a check: findings with their source lines, files and rehearsals."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.rehearsal import Rehearsal
from pirate_sm.core.documents import FileKind


@dataclass(frozen=True)
class CheckedFile:
    """A checked file, with its name in messages."""

    name: str
    kind: FileKind


@dataclass(frozen=True)
class CheckReport:
    """The result of a check.

    Attributes:
        findings: Distinct findings ordered by place, including allowed ones.
        files: The checked files.
        where: The searched files and folders.
        fixed: How many findings have been removed by changing files.
        fixable: How many can be removed by changing files, surely and by a guess.
        nothing: Whether there was no file to check.
        rehearsals: Results of running missions, if requested.
    """

    findings: tuple[Finding, ...]
    files: tuple[CheckedFile, ...]
    rehearsals: tuple[Rehearsal, ...] = ()
    where: tuple[str, ...] = ()
    fixed: int = 0
    fixable: tuple[int, int] = (0, 0)
    nothing: bool = False

    @property
    def open(self) -> tuple[Finding, ...]:
        """Return the findings that are not allowed."""
        return tuple(each for each in self.findings if not each.allowed)

    @property
    def allowed(self) -> tuple[Finding, ...]:
        """Return the allowed findings in the checked files, not in those that these use."""
        names = {file.name for file in self.files}
        return tuple(each for each in self.findings if each.allowed and each.place.file in names)

    def fails(self, at: Severity) -> bool:
        """Return whether there is a finding of this severity or worse."""
        return any(each.severity >= at for each in self.open)


_WIDTH = 100
_LONGEST = 1000  # characters of a line that a file for programs holds
_TOKEN = re.compile(r""" "(?:[^"\\]|\\.)*" | '(?:[^']|'')*' | \$?\w[\w.%-]* """, re.VERBOSE)


class Marked(NamedTuple):
    """A line of text, and a second line that marks a part of it."""

    line: str
    under: str


def end_column(finding: Finding) -> int:
    """Return the column after the word, name or quoted text at the finding's place, from 1."""
    start = max(finding.place.column, 1)
    match = _TOKEN.match(finding.excerpt, start - 1)
    return match.end() + 1 if match else start + 1


def marked(finding: Finding, width: int = _WIDTH) -> Marked | None:
    """Return the finding's line, cut to a width; None without a line."""
    if not finding.excerpt.strip() or not finding.place.line:
        return None
    line = "".join(char if char.isprintable() else " " for char in finding.excerpt.rstrip())
    start, end = max(finding.place.column, 1) - 1, end_column(finding) - 1
    first = len(line) - len(line.lstrip(" "))
    width = max(width, 20)
    if len(line) - first > width:
        first = max(first, min(start - width // 3, len(line) - width))
        line = line[: first + width]
    shown = line[first:]
    if first and line[:first].strip():
        shown = "…" + shown[1:]
    length = max(1, min(end, first + width) - start)
    return Marked(shown, " " * (start - first) + "^" * length)


def excerpt(finding: Finding) -> str:
    """Return the finding's line for programs, cut to a maximum length."""
    return finding.excerpt.rstrip()[:_LONGEST]
