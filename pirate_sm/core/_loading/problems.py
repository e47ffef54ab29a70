"""Problems of a file: message, place, expected input and suggestion.

Idioms of other languages are known, so that a message can say how something is written here.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeAlias

from pirate_sm.core._expressions.parser import ExpressionFault
from pirate_sm.core.errors import ExitCode, PirateError
from pirate_sm.core.spelling import nearest, one_of

if TYPE_CHECKING:
    from pirate_sm.core._expressions import ExpressionError
    from pirate_sm.core._loading.yaml.document import Document

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

    @classmethod
    def read(cls, text: str) -> Place:
        """Return the place of ``file:line:column``."""
        file, line, column = text.rsplit(":", 2)
        return cls(file, int(line), int(column))


@dataclass(frozen=True, slots=True, order=True)
class Edit:
    """A change within one line of a file that removes a fault.

    Attributes:
        place: Where the replaced text begins.
        end_column: The column after it; that of the place if text is only inserted.
        text: The replacement.
        safe: Whether nothing else can have been meant.
    """

    place: Place
    end_column: int
    text: str
    safe: bool = False


class Severity(IntEnum):
    """The severity of a problem or a finding of the check; a greater value is worse.

    ``POSSIBLE``: depends on something that the check cannot decide, such as a comparison of two
    sensors. ``WARNING``: can run, but is probably a mistake. ``ERROR``: is refused or goes wrong.
    """

    POSSIBLE = 1
    WARNING = 2
    ERROR = 3

    @property
    def word(self) -> str:
        """Return the name of the severity in messages and files."""
        return self.name.lower()


@dataclass(frozen=True, slots=True)
class Problem:
    """One fault of a file.

    Attributes:
        code: A stable identifier for programs, such as `unknown-key`.
        place: The place of the fault.
        message: What is wrong, for users.
        expected: The expected input; empty if the message contains it.
        suggestion: The text that was probably meant; empty if there is none.
        excerpt: The line of the file at the place.
        severity: Whether the file can be used nevertheless.
        edit: The change that removes the fault; None if it is not known.
    """

    code: str
    place: Place
    message: str
    expected: str = ""
    suggestion: str = ""
    excerpt: str = ""
    severity: Severity = Severity.ERROR
    edit: Edit | None = None

    def render(self) -> str:
        """Return the problem as lines of plain text: place and message, the line, hints."""
        warning = "warning: " if self.severity is Severity.WARNING else ""
        lines = [f"{self.place}: {warning}{cut(self.message)}"]
        if self.excerpt.strip():
            lines += _marked(self.excerpt, self.place.column)
        if self.expected:
            lines.append(f"  expected {cut(self.expected)}")
        if self.suggestion:
            lines.append(f"  did you mean '{cut(self.suggestion)}'?")
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.render()


def cut(text: str) -> str:
    """Return the text, shortened for a message: a name in a hostile file can be very long."""
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[: _LONGEST_MESSAGE - 1]}…"


def _marked(line: str, column: int) -> list[str]:
    """Return the line, with a caret under `column`, cut to the width of a terminal."""
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
    """Raised for files that cannot be used; holds all their problems, ordered by place."""

    exit_code: ClassVar[int] = ExitCode.USAGE

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=lambda problem: problem.place))
        lines = [problem.render() for problem in self.problems[:_MOST_SHOWN]]
        if len(self.problems) > _MOST_SHOWN:
            lines.append(f"… and {len(self.problems) - _MOST_SHOWN} more problems")
        super().__init__("\n".join(lines))


class Problems:
    """Collects the problems of one load, over all the files that take part in it."""

    def __init__(self, document: Document | None = None) -> None:
        self._document = document
        self._found: dict[Problem, None] = {}  # in order of discovery, without duplicates

    def about(self, document: Document) -> Problems:
        """Return a collector for another document that adds to the same problems."""
        view = Problems(document)
        view._found = self._found
        return view

    def put(self, problem: Problem) -> None:
        """Add a problem with its place, unless it is known already."""
        self._found[problem] = None

    def take(self, error: LoadError, code: str = "", path: Path = ()) -> None:
        """Add the problems of a file; with a code, those without a line there at a path here."""
        for problem in error.problems:
            if code and not problem.place.line:
                self.add(code, path, f"{problem.place}: {problem.message}")
            else:
                self.put(problem)

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
        length: int = 1,
        write: str = "",
        severity: Severity = Severity.ERROR,
    ) -> None:
        """Add a problem with the value at `path` of the document.

        Args:
            code: A stable identifier for programs.
            path: Keys and list indexes from the root of the document, as far as they exist.
            message: What is wrong.
            expected: The expected input.
            suggestion: The text that was probably meant.
            key: Point at the key instead of at its value.
            offset: Point this many characters into the text of the value.
            length: How many characters are wrong from there.
            write: What is to be written as the value, if nothing else can have been meant.
            severity: Whether the file can be used nevertheless.
        """
        if self._document is None:
            raise ValueError("these problems are not about a document: use about()")
        place = self._document.place_of(path, key=key, offset=offset)
        excerpt = self._document.excerpt(place.line, place.file)
        edit = None
        if new := write or suggestion:
            within = None if offset is None else (offset, offset + length)
            edit = self._document.edit_of(
                path, new, key=key and not write, within=within, safe=bool(write)
            )
        meant = suggestion.strip()
        self.put(Problem(code, place, message, expected, meant, excerpt, severity, edit))

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
        """Add a problem with an unknown name, and suggest the name that was probably meant.

        Args:
            code: A stable identifier for programs.
            path: Path of the name.
            kind: What is named, such as `joint`.
            name: The unknown name.
            known: The valid names.
            message: What is wrong, instead of `there is no KIND 'NAME'`.
            none: What is expected if no name is valid.
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
        """Add each fault of the expression at `path`, at its own column."""
        for fault in error.faults:
            self.add(
                "expression",
                path,
                fault.message,
                expected=_expression_form(fault),
                suggestion=fault.suggestion,
                offset=fault.offset,
                length=fault.length,
                write=fault.suggestion if fault.certain else "",
            )

    @property
    def all(self) -> tuple[Problem, ...]:
        """Return errors and warnings, ordered by place."""
        return tuple(sorted(self._found, key=lambda problem: problem.place))

    @property
    def errors(self) -> tuple[Problem, ...]:
        """Return the errors, ordered by place."""
        return tuple(problem for problem in self.all if problem.severity is Severity.ERROR)

    def raise_errors(self, but: Collection[str] = ()) -> None:
        """Raise an error if there are errors of codes that the caller does not tolerate.

        Raises:
            LoadError: There are such errors; holds all errors and warnings.
        """
        if any(problem.code not in but for problem in self.errors):
            raise LoadError(self._found)


_KEYS: Final = {
    **dict.fromkeys(("next", "goto", "then_go"), "go"),
    **dict.fromkeys(("actions", "steps", "then"), "do"),
    **dict.fromkeys(("print", "echo", "message"), "log"),
    **dict.fromkeys(("wait_until", "wait_for"), "wait"),
}

TRIGGER: Final = "after"
"""The key of a trigger for which its value alone may be written."""

_PAUSES: Final = {"sleep", "delay", "pause"}
_UNKNOWN_UNIT: Final = re.compile(r"unknown unit '(\w+)'")
_UNKNOWN_PARAMETER: Final = re.compile(r"there is no parameter '\$(\w+)'")


def meant_key(written: str, valid: Iterable[str]) -> str:
    """Return the valid key that is meant, or one that is spelt alike; empty if there is none."""
    known = list(valid)
    own = _KEYS.get(written, "")
    return own if own in known else nearest(written, known) or ""


def step_form(step: Mapping[str, Any]) -> str:
    """Return how a step of another language is written here; empty if that is not known."""
    key, value = next(iter(step.items()), ("", None))
    if "then" in step:
        return f"`choose: [{{if: {step.get('if', '…')}, do: …}}]`"
    if key in _PAUSES:
        return f"`wait: [{{after: {value}}}]`"
    if key == "goto":
        return f"`go: {value}` in the phase, next to its `do`"
    if not key[:1].isupper():
        return ""
    if isinstance(value, Mapping):
        return f"`{{command: {key}, {', '.join(f'{k}: {v}' for k, v in value.items())}}}`"
    return f"`{key}`, and how far in a wait: `when: change(odometry) >= {value}`"


def _expression_form(fault: ExpressionFault) -> str:
    """Return what is to be written instead of a faulty part of a condition, as far as known."""
    from pirate_sm.core._model.quantities import INCHES  # noqa: PLC0415 - pydantic is slow to load

    if (unit := _UNKNOWN_UNIT.match(fault.message)) and unit[1].lower() in INCHES:
        return f"mm: 1 {unit[1]} is {25.4 * INCHES[unit[1].lower()]:g} mm"
    if (name := _UNKNOWN_PARAMETER.match(fault.message)) and not fault.suggestion:
        return f"a declared one: `parameters: {{{name[1]}: {{type: …, default: …}}}}`"
    return "`==`" if fault.message.startswith("'is' ") else ""
