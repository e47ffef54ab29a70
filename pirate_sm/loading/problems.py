"""Problems with a file: what is wrong, where, what was expected, what was probably meant."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar, Protocol, TypeAlias

from pirate_sm.errors import PirateError
from pirate_sm.expressions import ExpressionError
from pirate_sm.spelling import nearest, one_of

Path: TypeAlias = tuple[str | int, ...]

_EXCERPT_WIDTH = 100
_LONGEST_MESSAGE = 300
_MOST_SHOWN = 50


@dataclass(frozen=True, slots=True, order=True)
class Place:
    """A place in a file, counted from 1; line 0 is the file as a whole."""

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}" if self.line else self.file


class Severity(StrEnum):
    """Says whether a problem keeps a file from being used."""

    ERROR = "error"
    WARNING = "warning"


@dataclass(frozen=True, slots=True)
class Problem:
    """One fault of a file.

    Attributes:
        code: A stable word for programs, such as `unknown-key`.
        place: Where the fault stands.
        message: What is wrong, for a person.
        expected: What would have been right; empty when the message says it.
        suggestion: What was probably meant, and nothing else; empty when nothing is near.
        excerpt: The line of the file that the place is on.
        severity: Whether the file can be used all the same.
    """

    code: str
    place: Place
    message: str
    expected: str = ""
    suggestion: str = ""
    excerpt: str = ""
    severity: Severity = Severity.ERROR

    def render(self) -> str:
        """Return the problem as lines of plain text: place and message, the line, hints."""
        warning = "warning: " if self.severity is Severity.WARNING else ""
        lines = [f"{self.place}: {warning}{_cut(self.message)}"]
        if self.excerpt.strip():
            lines += _marked(self.excerpt, self.place.column)
        if self.expected:
            lines.append(f"  expected {_cut(self.expected)}")
        if self.suggestion:
            lines.append(f"  did you mean '{_cut(self.suggestion)}'?")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.render()


def _cut(text: str) -> str:
    """Return text that a message can hold: names in a hostile file can be a megabyte long."""
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[: _LONGEST_MESSAGE - 1]}…"


def _marked(line: str, column: int) -> list[str]:
    """Return the line and a caret under `column`, cut to a width that a terminal shows."""
    flat = "".join(char if char.isprintable() else " " for char in line.rstrip())
    caret = max(column - 1, 0)
    start = 0
    if len(flat) > _EXCERPT_WIDTH:
        start = max(0, min(caret - _EXCERPT_WIDTH // 2, len(flat) - _EXCERPT_WIDTH))
        flat = flat[start : start + _EXCERPT_WIDTH]
        if start:
            flat = "…" + flat[1:]
    return [f"    {flat}", f"    {' ' * (caret - start)}^"]


class LoadError(PirateError):
    """Raised when files cannot be used; holds everything that is wrong with them, by place."""

    exit_code: ClassVar[int] = 2

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=lambda problem: problem.place))
        lines = [problem.render() for problem in self.problems[:_MOST_SHOWN]]
        if len(self.problems) > _MOST_SHOWN:
            lines.append(f"… and {len(self.problems) - _MOST_SHOWN} more problems")
        super().__init__("\n".join(lines))


class Locator(Protocol):
    """Finds the place of a value in a file; `loading.yaml.document.Document` is one."""

    def place_of(self, path: Path, *, key: bool = False, offset: int | None = None) -> Place:
        """Return the place of the value at `path`, or of its key."""
        ...

    def excerpt(self, line: int) -> str:
        """Return a line of the file, counted from 1; empty when there is none."""
        ...


class Problems:
    """Collects the problems of one load, over all the files that take part in it."""

    def __init__(self, document: Locator | None = None) -> None:
        self._document = document
        self._found: dict[Problem, None] = {}  # in the order of their discovery, each once

    def about(self, document: Locator) -> Problems:
        """Return a collector for another document that adds to the same problems."""
        view = Problems(document)
        view._found = self._found
        return view

    def put(self, problem: Problem) -> None:
        """Add a problem that knows its place, unless the same stands there already."""
        self._found[problem] = None

    def add(
        self,
        code: str,
        path: Path,
        message: str,
        *,
        expected: str = "",
        suggestion: str = "",
        key: bool = False,
        offset: int | None = None,
        severity: Severity = Severity.ERROR,
    ) -> None:
        """Add a problem with the value at `path` of the document.

        Args:
            code: A stable word for programs.
            path: Keys and list indexes from the root of the document; followed as far as it leads.
            message: What is wrong.
            expected: What would have been right.
            suggestion: What was probably meant.
            key: Point at the key instead of at its value.
            offset: Point this many characters into the text of the value.
            severity: Whether the file can be used all the same.
        """
        if self._document is None:
            raise ValueError("these problems are not about a document: use about()")
        place = self._document.place_of(path, key=key, offset=offset)
        excerpt = self._document.excerpt(place.line)
        self.put(Problem(code, place, message, expected, suggestion, excerpt, severity))

    def add_unknown(
        self,
        code: str,
        path: Path,
        kind: str,
        name: str,
        known: Iterable[str],
        *,
        message: str = "",
        none: str = "",
        key: bool = False,
    ) -> None:
        """Add that there is nothing of this kind and name, and which name was probably meant.

        Args:
            code: A stable word for programs.
            path: Where the name stands.
            kind: What is named, such as `joint`.
            name: The unknown name.
            known: The names that are valid there.
            message: What is wrong, in place of `there is no KIND 'NAME'`.
            none: What is expected when no name at all is valid.
            key: Point at the key instead of at its value.
        """
        names = list(known)
        self.add(
            code,
            path,
            message or f"there is no {kind} '{name}'",
            expected=none if none and not names else one_of(names),
            suggestion=nearest(name, names) or "",
            key=key,
        )

    def add_expression(self, path: Path, error: ExpressionError) -> None:
        """Add each fault of the expression that is the text at `path`, at its own column."""
        for fault in error.faults:
            self.add(
                "expression",
                path,
                fault.message,
                suggestion=fault.suggestion,
                offset=fault.offset,
            )

    @property
    def all(self) -> tuple[Problem, ...]:
        """Return errors and warnings, by place."""
        return tuple(sorted(self._found, key=lambda problem: problem.place))

    @property
    def errors(self) -> tuple[Problem, ...]:
        """Return what keeps the files from being used, by place."""
        return tuple(problem for problem in self.all if problem.severity is Severity.ERROR)

    def raise_errors(self, but: Collection[str] = ()) -> None:
        """Return only when there is no error, except of the codes that the caller can live with.

        Raises:
            LoadError: There is one; it holds the warnings too.
        """
        if any(problem.code not in but for problem in self.errors):
            raise LoadError(self._found)
