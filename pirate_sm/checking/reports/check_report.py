"""The result of a check: findings, files and rehearsals."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.rehearsal import Rehearsal
from pirate_sm.loading.file_kinds import Kind


@dataclass(frozen=True)
class CheckedFile:
    """A checked file, with its name in messages."""

    name: str
    kind: Kind


@dataclass(frozen=True)
class Report:
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
