"""Reports for programs: JSON, SARIF and workflow commands of GitHub; `junit` writes JUnit XML."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pirate_sm import __version__
from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, Rehearsal, end_column, excerpt
from pirate_sm.checking.reports.text import summary
from pirate_sm.core.documents import Edit, Place

# --- GitHub --------------------------------------------------------------------------------------


_COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.POSSIBLE: "notice"}


def github_report(report: CheckReport) -> str:
    """Return one command for each finding that is not allowed, followed by the summary."""
    return "\n".join([*map(_github_command, report.open), _github_data(summary(report))])


def _github_command(finding: Finding) -> str:
    place = finding.place
    properties = {"file": place.file.replace("\\", "/")}
    if place.line:
        properties |= {
            "line": str(place.line),
            "endLine": str(place.line),
            "col": str(place.column),
            "endColumn": str(end_column(finding)),
        }
    properties["title"] = f"{finding.code} ({finding.severity.word})"
    given = ",".join(f"{name}={_github_property(value)}" for name, value in properties.items())
    return f"::{_COMMANDS[finding.severity]} {given}::{_github_data(_github_message(finding))}"


def _github_message(finding: Finding) -> str:
    entry = catalogue.entry_of(finding.code)
    lines = [finding.message]
    lines += [f"{number}. {each}" for number, each in enumerate(finding.story, start=1)]
    if finding.suggestion:
        lines.append(f"Did you mean '{finding.suggestion}'?")
    lines += [line for line in (entry.why, finding.fix or entry.fix) if line]
    return "\n".join(lines)


def _github_data(text: str) -> str:
    """Return a message escaped so that it cannot contain a command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _github_property(text: str) -> str:
    return _github_data(text).replace(":", "%3A").replace(",", "%2C")


# --- JSON ----------------------------------------------------------------------------------------


JSON_FORMAT = 1


def json_report(report: CheckReport) -> str:
    """Return the report as one JSON object, in ASCII."""
    counts = {
        each.word: sum(found.severity is each for found in report.open)
        for each in sorted(Severity, reverse=True)
    }
    whole = {
        "format": JSON_FORMAT,
        "version": __version__,
        "files": [{"file": each.name, "kind": each.kind.value} for each in report.files],
        "findings": [_json_finding(each) for each in report.findings],
        "rehearsals": [_json_rehearsal(each) for each in report.rehearsals],
        "summary": {**counts, "allowed": len(report.allowed), "fixed": report.fixed},
    }
    return json.dumps(whole, indent=1)


def _json_finding(finding: Finding) -> dict[str, Any]:
    entry = catalogue.entry_of(finding.code)
    return {
        "code": finding.code,
        "severity": finding.severity.word,
        **_json_place(finding.place),
        "end_column": end_column(finding) if finding.place.line else 0,
        "title": entry.title,
        "message": finding.message,
        "why": entry.why,
        "mend": finding.fix or entry.fix,
        "suggestion": finding.suggestion,
        "excerpt": excerpt(finding),
        "related": [{**_json_place(place), "message": what} for place, what in finding.related],
        "story": list(finding.story),
        "example": finding.example,
        "edit": _json_edit(finding.edit),
        "allowed": finding.allowed,
    }


def _json_edit(edit: Edit | None) -> dict[str, Any] | None:
    if edit is None:
        return None
    return {
        **_json_place(edit.place),
        "end_line": edit.place.line,
        "end_column": edit.end_column,
        "replacement": edit.text,
        "safe": edit.safe,
    }


def _json_rehearsal(rehearsal: Rehearsal) -> dict[str, Any]:
    return {
        "file": rehearsal.file,
        "skipped": rehearsal.skipped,
        "runs": [asdict(each) for each in rehearsal.runs],
        "nearly": [asdict(each) for each in rehearsal.nearly],
    }


def _json_place(place: Place) -> dict[str, Any]:
    return {"file": place.file, "line": place.line, "column": place.column}


# --- SARIF ---------------------------------------------------------------------------------------


_ROOT = "%SRCROOT%"

_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
"""The identifier of the schema; nothing is downloaded."""

_INFORMATION = f"pkg:pypi/pirate-sm@{__version__}"
"""The package and its version as an absolute URI (package URL), because it has no web page."""
_LEVELS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.POSSIBLE: "note"}


def sarif_report(report: CheckReport) -> str:
    """Return one run with its rules, results and checked files, in ASCII."""
    codes = list(dict.fromkeys(finding.code for finding in report.findings))
    seen: Counter[str] = Counter()
    run = {
        "tool": {
            "driver": {
                "name": "pirate check",
                "version": __version__,
                "semanticVersion": __version__,
                "informationUri": _INFORMATION,
                "rules": [_sarif_rule(code) for code in codes],
            }
        },
        "columnKind": "unicodeCodePoints",
        "originalUriBaseIds": {_ROOT: {"description": _sarif_message("The folder of the check.")}},
        "artifacts": [
            {
                "location": _sarif_artifact(file.name),
                "roles": ["analysisTarget"],
                "description": _sarif_message(file.kind.value),
            }
            for file in report.files
        ],
        "results": [_sarif_result(each, codes.index(each.code), seen) for each in report.findings],
    }
    return json.dumps({"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}, indent=1)


def _sarif_rule(code: str) -> dict[str, Any]:
    entry = catalogue.entry_of(code)
    examples = f"Wrong:\n\n```yaml\n{entry.wrong.rstrip()}\n```\n\nRight:\n\n```yaml\n"
    return {
        "id": code,
        "shortDescription": _sarif_message(entry.title),
        "fullDescription": _sarif_message(f"{entry.title}. {entry.why}"),
        "help": {
            "text": f"{entry.why}\n{entry.fix}",
            "markdown": f"{entry.why}\n\n{entry.fix}\n\n{examples}{entry.right.rstrip()}\n```\n",
        },
        "defaultConfiguration": {"level": entry.severity},
        "properties": {"tags": [code.partition(".")[0]]},
    }


def _sarif_result(finding: Finding, rule: int, seen: Counter[str]) -> dict[str, Any]:
    entry = catalogue.entry_of(finding.code)
    meant = f" Did you mean '{finding.suggestion}'?" if finding.suggestion else ""
    text = f"{finding.message}.{meant} {finding.fix or entry.fix}"
    result: dict[str, Any] = {
        "ruleId": finding.code,
        "ruleIndex": rule,
        "level": _LEVELS[finding.severity],
        "message": _sarif_message(text),
        "locations": [{"physicalLocation": _sarif_location(finding)}],
        "partialFingerprints": {"finding/v1": _fingerprint(finding, seen)},
        "suppressions": _suppressions(finding),
    }
    if finding.related:
        result["relatedLocations"] = [
            {
                "id": number,
                "message": _sarif_message(what),
                "physicalLocation": _sarif_physical(place),
            }
            for number, (place, what) in enumerate(finding.related)
        ]
    if finding.story:
        result["codeFlows"] = [_sarif_flow(finding)]
    if finding.edit is not None:
        result["fixes"] = [_sarif_fix(finding.edit)]
    return result


def _sarif_fix(edit: Edit) -> dict[str, Any]:
    region = {
        "startLine": edit.place.line,
        "startColumn": edit.place.column,
        "endLine": edit.place.line,
        "endColumn": edit.end_column,
    }
    return {
        "description": _sarif_message(f"Write {edit.text}" + ("" if edit.safe else " (not sure)")),
        "artifactChanges": [
            {
                "artifactLocation": _sarif_artifact(edit.place.file),
                "replacements": [{"deletedRegion": region, "insertedContent": {"text": edit.text}}],
            }
        ],
    }


def _sarif_flow(finding: Finding) -> dict[str, Any]:
    """Return the story as a code flow, with all sentences at the place of the finding."""
    place = _sarif_location(finding)
    steps = [
        {"location": {"message": _sarif_message(each), "physicalLocation": place}}
        for each in finding.story
    ]
    return {"message": _sarif_message("How it comes about"), "threadFlows": [{"locations": steps}]}


def _suppressions(finding: Finding) -> list[dict[str, str]]:
    if not finding.allowed:
        return []
    return [{"kind": "inSource", "justification": finding.allowed}]


def _fingerprint(finding: Finding, seen: Counter[str]) -> str:
    """Return a digest that does not depend on line numbers, with a counter for duplicates."""
    said = (finding.code, finding.place.file, finding.excerpt.strip(), finding.message)
    digest = sha256("\0".join(said).encode("utf-8", "backslashreplace")).hexdigest()[:32]
    seen[digest] += 1
    return f"{digest}:{seen[digest]}"


def _sarif_location(finding: Finding) -> dict[str, Any]:
    location = _sarif_physical(finding.place)
    if finding.place.line:
        location["region"]["endColumn"] = end_column(finding)
        if finding.excerpt:
            location["region"]["snippet"] = {"text": excerpt(finding)}
    return location


def _sarif_physical(place: Place) -> dict[str, Any]:
    location: dict[str, Any] = {"artifactLocation": _sarif_artifact(place.file)}
    if place.line:
        location["region"] = {"startLine": place.line, "startColumn": max(place.column, 1)}
    return location


def _sarif_artifact(name: str) -> dict[str, str]:
    path = Path(name)
    if path.is_absolute():
        return {"uri": path.as_uri()}
    posix = path.as_posix().encode("utf-8", "surrogateescape")
    return {"uri": quote(posix), "uriBaseId": _ROOT}


def _sarif_message(text: str) -> dict[str, str]:
    return {"text": text}
