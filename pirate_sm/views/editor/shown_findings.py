"""Findings of the check as editors show them, and their changes as actions."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from lsprotocol.types import (
    CodeAction,
    CodeActionKind,
    Diagnostic,
    DiagnosticRelatedInformation,
    DiagnosticSeverity,
    Location,
    Range,
    TextEdit,
    WorkspaceEdit,
)
from pygls.uris import from_fs_path
from pygls.workspace import PositionCodec

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, changes_of
from pirate_sm.checking.reports.text import advice
from pirate_sm.core.documents import LARGEST_FILE, Place
from pirate_sm.core.on_disk import opened, unsaved
from pirate_sm.views.editor.positions import Positions

SOURCE = "pirate_sm"
"""What findings are from, for editors that show those of several programs."""

_SEVERITIES = {
    Severity.ERROR: DiagnosticSeverity.Error,
    Severity.WARNING: DiagnosticSeverity.Warning,
    Severity.POSSIBLE: DiagnosticSeverity.Information,
}


@dataclass
class CheckedTexts:
    """What the check says of the files in an editor.

    Attributes:
        report: The report.
        texts: The contents of the open files by their paths, as they were checked.
        uris: How the editor calls them.
        codec: Counts characters as the editor does.
    """

    report: CheckReport
    texts: Mapping[str, bytes]
    uris: Mapping[str, str]
    codec: PositionCodec
    _positions: dict[str, Positions] = field(default_factory=dict)

    def diagnostics(self) -> dict[str, list[Diagnostic]]:
        """Return what is to be shown in each file, also where nothing is, if the file is open."""
        shown: dict[str, list[Diagnostic]] = {uri: [] for uri in self.uris.values()}
        for finding in self.report.open:
            shown.setdefault(self._uri(finding.place.file), []).append(self._diagnostic(finding))
        return shown

    def actions(self, path: str, wanted: Range) -> Iterator[CodeAction]:
        """Yield the changes that remove findings.

        Args:
            path: The path of an open file.
            wanted: The part of the file whose findings count.
        """
        for finding in self.report.open:
            edit = finding.edit
            if edit is None or os.path.realpath(finding.place.file) != path:
                continue
            found = self._diagnostic(finding)
            if found.range.start <= wanted.end and wanted.start <= found.range.end:
                where = self._on(edit.place.file).of_edit(edit)
                made = self._edit(edit.place.file, where, edit.text)
                title = f"Write '{edit.text}'" if edit.text.strip() else "Remove it"
                kind = CodeActionKind.QuickFix
                yield CodeAction(title, kind, [found], edit=made, is_preferred=edit.safe)
        with unsaved(self.texts):
            changes = changes_of(self.report, [path], unsafe=False)
        for change in changes:
            whole = self._on(change.name).everything
            title = "Make all changes that leave no choice"
            made = self._edit(change.name, whole, change.after)
            yield CodeAction(title, CodeActionKind.SourceFixAll, edit=made)

    def _edit(self, name: str, where: Range, text: str) -> WorkspaceEdit:
        return WorkspaceEdit(changes={self._uri(name): [TextEdit(where, text)]})

    def _diagnostic(self, finding: Finding) -> Diagnostic:
        why = catalogue.entry_of(finding.code).why
        lines = finding.message, why and f"why: {why}", f"fix: {advice(finding)}"
        here = self._location(finding.place)
        related = [(self._location(place), what) for place, what in finding.related]
        related += [(here, f"{n}. {event}") for n, event in enumerate(finding.story, start=1)]
        return Diagnostic(
            self._on(finding.place.file).of_finding(finding),
            "\n".join(filter(None, lines)),
            severity=_SEVERITIES[finding.severity],
            code=finding.code,
            source=SOURCE,
            related_information=[DiagnosticRelatedInformation(*each) for each in related],
        )

    def _location(self, place: Place) -> Location:
        return Location(self._uri(place.file), self._on(place.file).of_place(place, place.column))

    def _uri(self, name: str) -> str:
        """Return how the editor calls a file."""
        path = os.path.realpath(name)
        return self.uris.get(path) or str(from_fs_path(path))

    def _on(self, name: str) -> Positions:
        """Return the positions in a file; in an empty one if it cannot be read."""
        if name not in self._positions:
            with unsaved(self.texts):
                text = text_on_disk(name)
            self._positions[name] = Positions(text, self.codec)
        return self._positions[name]


def text_on_disk(name: str) -> str:
    """Return the text of a file; an empty one if it cannot be read."""
    content = b""
    with suppress(OSError, ValueError), opened(name) as stream:
        content = stream.read(LARGEST_FILE)
    return content.decode("utf-8-sig", errors="replace")


def of_kinds(
    actions: Iterable[CodeAction], only: Sequence[CodeActionKind | str]
) -> list[CodeAction]:
    """Return the actions of some kinds, of which there is a hierarchy; all without any kind."""
    kinds = tuple(f"{_plain(kind)}." for kind in only)
    return [each for each in actions if not only or f"{_plain(each.kind)}.".startswith(kinds)]


def _plain(kind: CodeActionKind | str | None) -> str | None:
    return kind.value if isinstance(kind, CodeActionKind) else kind
