"""Findings of checks: what is wrong, how certain it is, where, and how it happens."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from pirate_sm.checking import catalogue
from pirate_sm.core.documents import Edit, Locator, Place, Problem, Severity, cut

if TYPE_CHECKING:
    from pirate_sm.checking.exploring.exploration import Exploration

__all__ = ["Finding", "Severity", "at", "each_once", "finding_of", "usual_severity"]


@dataclass(frozen=True)
class Finding:
    """One finding of a check.

    Attributes:
        code: A stable identifier for programs, explained in :mod:`pirate_sm.checking.catalogue`.
        place: Its place.
        message: What is wrong, in one sentence.
        fix: How to fix it, if this is more than the catalogue's advice for the code.
        suggestion: The name that was probably meant.
        excerpt: The source line of the place.
        related: Related places, each with an explanation.
        story: How it happens, with one sentence for each event, in order.
        example: File of the trace script that reproduces the story; empty without one.
        course: The exploration and the index of its step; empty without one.
        edit: The change that removes it; None if it is not known.
        allowed: The reason in a comment that allows it; empty if it is not allowed.
    """

    code: str
    severity: Severity
    place: Place
    message: str
    fix: str = ""
    suggestion: str = ""
    excerpt: str = ""
    related: tuple[tuple[Place, str], ...] = ()
    story: tuple[str, ...] = ()
    example: str = ""
    course: tuple[tuple[Exploration, int], ...] = field(default=(), compare=False, repr=False)
    edit: Edit | None = None
    allowed: str = field(default="", compare=False)

    def __repr__(self) -> str:
        allowed = f" (allowed: {self.allowed})" if self.allowed else ""
        return f"<Finding {self.place}: {self.severity.word} [{self.code}] {self.message}{allowed}>"

    @property
    def order(self) -> tuple[Place, str, str]:
        """Return the sort key: place, then code, then message."""
        return self.place, self.code, self.message

    def allow(self, reason: str) -> Finding:
        """Return the finding as allowed for a reason."""
        return replace(self, allowed=reason)


def finding_of(problem: Problem) -> Finding:
    """Return a problem of loading as a finding."""
    return Finding(
        problem.code,
        problem.severity,
        problem.place,
        problem.message,
        fix=f"expected {problem.expected}" if problem.expected else "",
        suggestion=problem.suggestion,
        excerpt=problem.excerpt,
        edit=problem.edit,
    )


def usual_severity(code: str) -> Severity:
    """Return the severity that the catalogue gives to a code."""
    return Severity[catalogue.entry_of(code).severity.upper()]


def at(
    document: Locator,
    place: Place,
    code: str,
    message: str,
    *,
    severity: Severity | None = None,
    fix: str = "",
    related: Iterable[tuple[Place, str]] = (),
) -> Finding:
    """Return a finding at a place of a document, with its source line.

    Args:
        document: The file.
        place: The place in the file.
        code: An entry of the catalogue.
        message: What is wrong, in one sentence.
        severity: The severity; None for the usual one of the code.
        fix: How to fix it, if this is more than the catalogue's advice.
        related: Related places, each with an explanation.
    """
    severity = usual_severity(code) if severity is None else severity
    excerpt = document.excerpt(place.line, place.file)
    return Finding(code, severity, place, message, fix=fix, excerpt=excerpt, related=tuple(related))


def each_once(findings: Iterable[Finding]) -> list[Finding]:
    """Return one finding per code, place and message: the worst, then the shortest."""
    kept: dict[tuple[str, Place, str], Finding] = {}
    for finding in map(_short, findings):
        key = finding.code, finding.place, finding.message
        before = kept.get(key)
        if before is None or _weight(finding) > _weight(before):
            kept[key] = finding
    return list(kept.values())


def _short(finding: Finding) -> Finding:
    """Return the finding with a shortened message, because names in a file can be very long."""
    message, fix, suggestion = map(cut, (finding.message, finding.fix, finding.suggestion))
    return replace(finding, message=message, fix=fix, suggestion=suggestion)


def _weight(finding: Finding) -> tuple[int, bool, int]:
    """Return the rank of a finding: by severity, then with a story, then the shortest."""
    return finding.severity, bool(finding.story), -len(finding.story)
