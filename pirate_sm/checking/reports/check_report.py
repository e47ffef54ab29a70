"""What a check has found: findings, files and rehearsals."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.checking.file_kinds import Kind
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.rehearsal import Rehearsal


@dataclass(frozen=True)
class CheckedFile:
    """A file that was looked at, as messages name it."""

    name: str
    kind: Kind


@dataclass(frozen=True)
class Report:
    """What a check has found.

    Attributes:
        findings: By place, each once; allowed ones too.
        files: What was looked at.
        where: The files and folders that were searched.
        nothing: Whether there was no file at all to look at.
        rehearsals: What came of running missions, where that was wanted.
    """

    findings: tuple[Finding, ...]
    files: tuple[CheckedFile, ...]
    rehearsals: tuple[Rehearsal, ...] = ()
    where: tuple[str, ...] = ()
    nothing: bool = False

    @property
    def open(self) -> tuple[Finding, ...]:
        """The findings that nobody has allowed."""
        return tuple(each for each in self.findings if not each.allowed)

    @property
    def allowed(self) -> tuple[Finding, ...]:
        """The findings that may stay."""
        return tuple(each for each in self.findings if each.allowed)

    def fails(self, at: Severity) -> bool:
        """Return whether anything was found that is as bad as this, or worse."""
        return any(each.severity >= at for each in self.open)
