"""Change the files of a project by the edits of their findings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from difflib import unified_diff
from pathlib import Path
from typing import TypeAlias

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.permissions import is_below
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.core.documents import Edit
from pirate_sm.core.errors import UsageError
from pirate_sm.core.on_disk import is_folder, is_there, opened, replace_file

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
