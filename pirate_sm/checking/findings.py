"""Findings of checks: what is wrong, how certain it is, where, and how it happens."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import yaml

from pirate_sm.checking import catalogue
from pirate_sm.core.documents import LARGEST_FILE, Document, Edit, Place, Problem, Severity, cut

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


def written(finding: Finding) -> dict[str, Any]:
    """Return a finding as JSON, without the exploration that it came of."""
    return asdict(replace(finding, course=()))


def read(data: Mapping[str, Any]) -> Finding:
    """Return the finding that was written."""
    edit = data["edit"] and Edit(**{**data["edit"], "place": Place(**data["edit"]["place"])})
    return Finding(
        **{
            **data,
            "severity": Severity(data["severity"]),
            "place": Place(**data["place"]),
            "related": tuple((Place(**place), what) for place, what in data["related"]),
            "story": tuple(data["story"]),
            "course": (),
            "edit": edit,
        }
    )


def usual_severity(code: str) -> Severity:
    """Return the severity that the catalogue gives to a code."""
    return Severity[catalogue.entry_of(code).severity.upper()]


def at(
    document: Document,
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


# --- comments that allow findings ----------------------------------------------------------------
# One comment may have several codes, separated by commas. On the first line of a text in block
# style (`|` or `>`), which can hold no comments itself, the comment is about all of its lines.


_MARK = re.compile(r"#[ \t]*pirate:[ \t]*allow\b[ \t]*(?P<said>.*)")
_CODE = re.compile(r"[^\s,][^,]*")
_BLANK = re.compile(r"\s")

# As the composer of documents, which says where the two differ.
_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True)
class Allowance:
    """One code that a comment allows.

    Attributes:
        place: The place of the code in the comment.
        lines: The lines on which the code is allowed.
        reason: The reason; empty if the comment gives none.
        excerpt: The line of the comment.
    """

    code: str
    place: Place
    lines: range
    reason: str
    excerpt: str


@lru_cache(maxsize=64)  # a program runs the same few missions repeatedly
def allowances(name: str, text: str) -> tuple[Allowance, ...]:
    """Return all allowances in a file.

    Args:
        name: Name of the file in findings.
        text: The content of the file.
    """
    if "pirate:" not in text or len(text) > LARGEST_FILE:
        return ()
    texts = _Texts(text)
    found: list[Allowance] = []
    begin = 0
    for number, line in enumerate(text.splitlines(keepends=True), start=1):
        mark = _MARK.search(line)
        if mark and _begins_comment(line, mark.start()) and not texts.hold(begin + mark.start()):
            found += _said(name, number, line.rstrip("\r\n"), mark, texts)
        begin += len(line)
    return tuple(found)


def settle(found: Iterable[Finding], files: Mapping[str, str]) -> tuple[Finding, ...]:
    """Return the findings with allowed ones marked, and with findings about faulty allowances.

    Args:
        found: All findings, without duplicates.
        files: Text of every checked file, by its name in findings.
    """
    every = [each for name, text in files.items() for each in allowances(name, text)]
    by_file: dict[str, list[Allowance]] = {}
    for allowance in every:
        by_file.setdefault(allowance.place.file, []).append(allowance)
    used: set[Place] = set()
    settled = []
    for finding in found:
        match = _allowing(finding, by_file.get(finding.place.file, ()))
        if match is None:
            settled.append(finding)
        else:
            used.add(match.place)
            settled.append(finding.allow(match.reason))
    faults = (fault for each in every for fault in _faults(each, each.place in used))
    return (*settled, *faults)


def _allowing(finding: Finding, known: Iterable[Allowance]) -> Allowance | None:
    """Return the valid allowance for a finding, None without one."""
    for allowance in known:
        if finding.code == allowance.code and finding.place.line in allowance.lines:
            return allowance if finding.code in catalogue.allowable() else None
    return None


def _faults(allowance: Allowance, used: bool) -> Iterator[Finding]:
    """Yield findings about an allowance."""
    code = allowance.code
    if not allowance.reason:
        message = (
            f"'{code}' is allowed here without a reason" if code else "no code is allowed here"
        )
        yield _finding(allowance, "allow.reason", message)
    elif code not in catalogue.entries():
        close = catalogue.nearest_code(code) or ""
        message = f"there is no code '{code}'"
        fault = _finding(allowance, "allow.unused", message)
        edit = close and Edit(allowance.place, allowance.place.column + len(code), close)
        yield replace(fault, suggestion=close, edit=edit or None)
    elif code not in catalogue.allowable():
        message = f"'{code}' cannot be allowed: it keeps the file from being used"
        yield _finding(allowance, "allow.unused", message)
    elif not used:
        message = f"'{code}' is allowed here and was not found"
        yield _finding(allowance, "allow.unused", message)


def _finding(allowance: Allowance, code: str, message: str) -> Finding:
    return Finding(code, usual_severity(code), allowance.place, message, excerpt=allowance.excerpt)


def _begins_comment(line: str, start: int) -> bool:
    return start == 0 or line[start - 1] in " \t"


def _said(
    name: str, number: int, line: str, mark: re.Match[str], texts: _Texts
) -> Iterator[Allowance]:
    """Yield the allowances of a comment; a single one without a code if it names none."""
    codes, _, reason = mark["said"].partition(":")
    lines = texts.under(number)
    named = list(_CODE.finditer(codes))
    if not named:
        yield Allowance("", Place(name, number, mark.start() + 1), lines, "", line)
    # Words after the code without a colon may be a reason or a mistake.
    whole = "" if any(_BLANK.search(code[0].strip()) for code in named) else reason.strip()
    for code in named:
        place = Place(name, number, mark.start("said") + code.start() + 1)
        yield Allowance(code[0].split()[0], place, lines, whole, line)


class _Texts:
    """The quoted and block texts of a file, in which `#` does not begin a comment."""

    def __init__(self, text: str) -> None:
        self._spans: list[tuple[int, int]] = []
        self._blocks: dict[int, range] = {}
        try:
            for token in yaml.scan(text, Loader=_Loader):
                if isinstance(token, yaml.ScalarToken):
                    self._take(token, text)
        except yaml.YAMLError:
            return  # what cannot be read has findings of its own

    def hold(self, position: int) -> bool:
        """Return whether a position in the file is inside a text."""
        return any(start <= position < end for start, end in self._spans)

    def under(self, line: int) -> range:
        """Return the lines to which a comment on this line applies."""
        return self._blocks.get(line, range(line, line + 1))

    def _take(self, token: yaml.ScalarToken, text: str) -> None:
        start, end = token.start_mark, token.end_mark
        first = start.index
        if token.style in ("|", ">"):
            first = text.find("\n", start.index) + 1 or end.index
            self._blocks[start.line + 1] = range(start.line + 1, end.line + 1)
        self._spans.append((first, end.index))
