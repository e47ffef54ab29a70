"""Reports as JSON, described by ``docs/schemas/check.schema.json``."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from pirate_sm import __version__
from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.mission.rehearsal import Rehearsal
from pirate_sm.checking.reports.check_report import CheckReport, end_column, excerpt
from pirate_sm.core.documents import Edit, Place

FORMAT = 1


def json_report(report: CheckReport) -> str:
    """Return the report as one JSON object, in ASCII."""
    counts = {
        each.word: sum(found.severity is each for found in report.open)
        for each in sorted(Severity, reverse=True)
    }
    whole = {
        "format": FORMAT,
        "version": __version__,
        "files": [{"file": each.name, "kind": each.kind.value} for each in report.files],
        "findings": [_finding(each) for each in report.findings],
        "rehearsals": [_rehearsal(each) for each in report.rehearsals],
        "summary": {**counts, "allowed": len(report.allowed), "fixed": report.fixed},
    }
    return json.dumps(whole, indent=1)


def _finding(finding: Finding) -> dict[str, Any]:
    entry = catalogue.entry_of(finding.code)
    return {
        "code": finding.code,
        "severity": finding.severity.word,
        **_place(finding.place),
        "end_column": end_column(finding) if finding.place.line else 0,
        "title": entry.title,
        "message": finding.message,
        "why": entry.why,
        "mend": finding.fix or entry.fix,
        "suggestion": finding.suggestion,
        "excerpt": excerpt(finding),
        "related": [{**_place(place), "message": what} for place, what in finding.related],
        "story": list(finding.story),
        "example": finding.example,
        "edit": _edit(finding.edit),
        "allowed": finding.allowed,
    }


def _edit(edit: Edit | None) -> dict[str, Any] | None:
    if edit is None:
        return None
    return {
        **_place(edit.place),
        "end_line": edit.place.line,
        "end_column": edit.end_column,
        "replacement": edit.text,
        "safe": edit.safe,
    }


def _rehearsal(rehearsal: Rehearsal) -> dict[str, Any]:
    return {
        "file": rehearsal.file,
        "skipped": rehearsal.skipped,
        "runs": [asdict(each) for each in rehearsal.runs],
        "nearly": [asdict(each) for each in rehearsal.nearly],
    }


def _place(place: Place) -> dict[str, Any]:
    return {"file": place.file, "line": place.line, "column": place.column}
