"""A finding: what is wrong, how surely, where, and how it comes about."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import TYPE_CHECKING

from pirate_sm.checking import catalogue
from pirate_sm.loading.problems import Locator, Place, Problem
from pirate_sm.loading.problems import Severity as LoadSeverity

if TYPE_CHECKING:
    from pirate_sm.checking.exploring.exploration import Exploration


class Severity(IntEnum):
    """How surely something is wrong; greater is worse.

    ``POSSIBLE`` depends on what the check cannot decide, such as two sensors compared with each
    other; ``WARNING`` can run and is hardly meant; ``ERROR`` will be refused or goes wrong.
    """

    POSSIBLE = 1
    WARNING = 2
    ERROR = 3

    @property
    def word(self) -> str:
        """Its name in messages and files."""
        return self.name.lower()


@dataclass(frozen=True)
class Finding:
    """One thing that a person should know before anything moves.

    Attributes:
        code: A stable word for programs, explained in :mod:`pirate_sm.checking.catalogue`.
        place: Where it stands.
        message: What is wrong, in one sentence.
        mend: How to mend it, where this is more than the catalogue says of the code.
        suggestion: A name that was probably meant.
        excerpt: The source line of the place.
        related: Further places with what they have to do with it.
        story: How it comes about, one sentence for each event, the first one first.
        example: File of the script that plays the story in a trace; empty without one.
        course: The exploration and the step of it in which it comes about; empty without one.
        allowed: Why it may stay, said in a comment on its line; empty: it may not.
    """

    code: str
    severity: Severity
    place: Place
    message: str
    mend: str = ""
    suggestion: str = ""
    excerpt: str = ""
    related: tuple[tuple[Place, str], ...] = ()
    story: tuple[str, ...] = ()
    example: str = ""
    course: tuple[tuple[Exploration, int], ...] = field(default=(), compare=False, repr=False)
    allowed: str = field(default="", compare=False)

    def __repr__(self) -> str:
        allowed = f" (allowed: {self.allowed})" if self.allowed else ""
        return f"<Finding {self.place}: {self.severity.word} [{self.code}] {self.message}{allowed}>"

    @property
    def order(self) -> tuple[Place, str, str]:
        """Findings are ordered by place, then code."""
        return self.place, self.code, self.message

    def allow(self, reason: str) -> Finding:
        """Return the same finding, allowed."""
        return replace(self, allowed=reason)


def finding_of(problem: Problem) -> Finding:
    """Return the finding that says what loading found."""
    warning = problem.severity is LoadSeverity.WARNING
    return Finding(
        problem.code,
        Severity.WARNING if warning else Severity.ERROR,
        problem.place,
        problem.message,
        mend=f"expected {problem.expected}" if problem.expected else "",
        suggestion=problem.suggestion,
        excerpt=problem.excerpt,
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
    mend: str = "",
    related: Iterable[tuple[Place, str]] = (),
) -> Finding:
    """Return a finding at a place of a document, with the line that stands there.

    Args:
        document: The file.
        place: Where in it.
        code: An entry of the catalogue.
        message: What is wrong, in one sentence.
        severity: None: the usual one of the code.
        mend: How to mend it, where this is more than the catalogue says.
        related: Further places with what they have to do with it.
    """
    severity = usual_severity(code) if severity is None else severity
    excerpt = document.excerpt(place.line)
    return Finding(
        code, severity, place, message, mend=mend, excerpt=excerpt, related=tuple(related)
    )
