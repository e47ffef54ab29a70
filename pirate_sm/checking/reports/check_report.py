"""The result of a check: findings with their lines, files, rehearsals; and changes of files."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from typing import NamedTuple, TypeAlias

from pirate_sm.checking.findings import Finding, Severity, settle
from pirate_sm.checking.mission.check_mission import MissionCheck
from pirate_sm.checking.mission.mission_view import MissionPlaces
from pirate_sm.checking.permissions import is_below
from pirate_sm.core.documents import Edit, FileKind
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.on_disk import is_folder, is_there, opened, replace_file

# --- rehearsals ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class RehearsedRun:
    """The result of one run.

    Attributes:
        outcome: The engine's outcome: ``succeeded``, ``failed``, ``fault`` or ``interrupted``.
        message: The reason.
        time_s: Its duration in mission time.
    """

    seed: int
    outcome: str
    message: str
    time_s: float

    @property
    def succeeded(self) -> bool:
        """Return whether the mission succeeded."""
        return self.outcome == "succeeded"


@dataclass(frozen=True)
class Nearly:
    """A near miss in a run.

    Attributes:
        text: A description with numbers.
        share: How close it was; it happens at 1.
        at_s: Mission time.
    """

    text: str
    share: float
    at_s: float
    seed: int


@dataclass(frozen=True)
class Rehearsal:
    """The runs of one mission.

    Attributes:
        file: Its file, as in messages.
        nearly: The near misses of all runs, the closest first.
        skipped: Why there are no runs; empty if there are.
        at_once: Places of triggers whose condition was true at the start of their wait, with text.
    """

    file: str
    runs: tuple[RehearsedRun, ...] = ()
    nearly: tuple[Nearly, ...] = ()
    skipped: str = ""
    at_once: tuple[tuple[str, str], ...] = ()


Rehearse: TypeAlias = Callable[[LoadedMission, Path], Rehearsal]
"""Runs the mission that was read from this file."""


def rehearsed(
    check: MissionCheck, path: Path, rehearse: Rehearse
) -> tuple[Rehearsal, tuple[Finding, ...]]:
    """Run a mission without errors in the simulator, and return the results and findings.

    Args:
        check: The result of the mission's check.
        path: Its file.
        rehearse: Runs it.
    """
    texts = {document.name: document.text for document in check.documents}
    settled = settle(check.findings, texts)
    wrong = any(each.severity is Severity.ERROR and not each.allowed for each in settled)
    if check.loaded is None or wrong:
        return Rehearsal(shown(path), skipped="the check has found errors in it"), ()
    done = rehearse(check.loaded, path)
    places = MissionPlaces(check.loaded)
    found = [
        places.finding(
            places.read(place),
            "rehearsal.at_once",
            f"in the simulator '{text}' was true already as its wait began",
        )
        for place, text in done.at_once
    ]
    failed = [run for run in done.runs if not run.succeeded]
    if not failed:
        return done, tuple(found)
    first = failed[0]
    message = f"in the simulator it does not succeed: {first.message} (after {first.time_s:.1f} s)"
    if len(done.runs) > 1:
        seeds = ", ".join(str(run.seed) for run in failed)
        message += f"; {len(failed)} of {len(done.runs)} runs, with the seeds {seeds}"
    found.append(places.finding(places.mission(), "rehearsal.failed", message))
    return done, tuple(found)


# --- reports -------------------------------------------------------------------------------------


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


# --- lines of findings ------------------------------------------------------------------------


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


# --- changes of files -------------------------------------------------------------------------


_BOM = "\ufeff"
_Line: TypeAlias = tuple[Edit, str]
"""An edit with the line that it was made for."""


@dataclass(frozen=True)
class FileChange:
    """What fixing makes of one file.

    Attributes:
        name: Its name in messages.
        fixed: How many findings it removes.
        safe: How many of these are surely what was meant.
    """

    name: str
    before: str
    after: str
    fixed: int
    safe: int

    def diff(self) -> str:
        """Return it as a unified diff."""
        lines = self.before.splitlines(), self.after.splitlines()
        return "\n".join(unified_diff(*lines, self.name, self.name, lineterm=""))

    def write(self) -> None:
        """Replace the file; its encoding and line ends stay.

        Raises:
            UsageError: It cannot be written.
        """
        try:
            replace_file(Path(self.name).resolve(), self.after.encode())
        except OSError as error:
            raise UsageError(f"{self.name} cannot be changed: {error.strerror}") from None


def changes_of(report: CheckReport, paths: Iterable[str], *, unsafe: bool) -> list[FileChange]:
    """Return what fixing makes of the checked files.

    Files that they use are left alone, and links out of the folders that were checked, unless
    they are named themselves.

    Args:
        report: The findings.
        paths: The files and folders that were checked; empty for the working directory.
        unsafe: Whether edits that may not be what was meant count too.
    """
    given = [Path(each) for each in paths if is_there(each)] if paths else [Path()]
    folders = [*given, *(each.parent for each in given if not is_folder(each))]
    names = dict.fromkeys(file.name for file in report.files)
    own = [name for name in names if any(is_below(Path(name), folder) for folder in folders)]
    changes = (_change(name, list(_fixable(report.open, name, unsafe=unsafe))) for name in own)
    return [change for change in changes if change is not None]


def _fixable(findings: Iterable[Finding], name: str, *, unsafe: bool) -> Iterator[_Line]:
    for finding in findings:
        edit = finding.edit
        if edit is not None and edit.place.file == name and (edit.safe or unsafe):
            yield edit, finding.excerpt


def _change(name: str, wanted: list[_Line]) -> FileChange | None:
    """Return a file with all edits that do not overlap, from its end to its beginning."""
    if not wanted:
        return None
    try:
        with opened(name) as stream:
            before = stream.read().decode()
    except (OSError, ValueError):
        return None
    bom = _BOM if before.startswith(_BOM) else ""
    lines = before.removeprefix(_BOM).splitlines(keepends=True)
    as_checked = dict(enumerate(before.removeprefix(_BOM).splitlines(), start=1))
    sound = [edit for edit, line in wanted if as_checked.get(edit.place.line) == line]
    done: set[Edit] = set()
    begin = (len(lines) + 1, 1)  # of the edit after
    for edit in sorted(set(sound), reverse=True):
        number, column = edit.place.line, edit.place.column
        if (number, edit.end_column) > begin:
            continue  # it overlaps the edit after it, or is another one of the same text
        line = lines[number - 1]
        lines[number - 1] = line[: column - 1] + edit.text + line[edit.end_column - 1 :]
        begin = number, column
        done.add(edit)
    safe = [edit.safe for edit in sound if edit in done]
    return FileChange(name, before, bom + "".join(lines), len(safe), sum(safe)) if done else None
