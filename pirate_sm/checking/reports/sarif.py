"""Reports in SARIF 2.1.0, which code hosts and editors read (OASIS, 2023)."""

from __future__ import annotations

import json
from collections import Counter
from hashlib import sha256
from pathlib import Path
from typing import Any
from urllib.parse import quote

from pirate_sm import __version__
from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, end_column, excerpt
from pirate_sm.core.documents import Edit, Place

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
                "rules": [_rule(code) for code in codes],
            }
        },
        "columnKind": "unicodeCodePoints",
        "originalUriBaseIds": {_ROOT: {"description": _message("The folder of the check.")}},
        "artifacts": [
            {
                "location": _artifact(file.name),
                "roles": ["analysisTarget"],
                "description": _message(file.kind.value),
            }
            for file in report.files
        ],
        "results": [_result(each, codes.index(each.code), seen) for each in report.findings],
    }
    return json.dumps({"$schema": _SCHEMA, "version": "2.1.0", "runs": [run]}, indent=1)


def _rule(code: str) -> dict[str, Any]:
    entry = catalogue.entry_of(code)
    examples = f"Wrong:\n\n```yaml\n{entry.wrong.rstrip()}\n```\n\nRight:\n\n```yaml\n"
    return {
        "id": code,
        "shortDescription": _message(entry.title),
        "fullDescription": _message(f"{entry.title}. {entry.why}"),
        "help": {
            "text": f"{entry.why}\n{entry.fix}",
            "markdown": f"{entry.why}\n\n{entry.fix}\n\n{examples}{entry.right.rstrip()}\n```\n",
        },
        "defaultConfiguration": {"level": entry.severity},
        "properties": {"tags": [code.partition(".")[0]]},
    }


def _result(finding: Finding, rule: int, seen: Counter[str]) -> dict[str, Any]:
    entry = catalogue.entry_of(finding.code)
    meant = f" Did you mean '{finding.suggestion}'?" if finding.suggestion else ""
    text = f"{finding.message}.{meant} {finding.fix or entry.fix}"
    result: dict[str, Any] = {
        "ruleId": finding.code,
        "ruleIndex": rule,
        "level": _LEVELS[finding.severity],
        "message": _message(text),
        "locations": [{"physicalLocation": _location(finding)}],
        "partialFingerprints": {"finding/v1": _fingerprint(finding, seen)},
        "suppressions": _suppressions(finding),
    }
    if finding.related:
        result["relatedLocations"] = [
            {"id": number, "message": _message(what), "physicalLocation": _physical(place)}
            for number, (place, what) in enumerate(finding.related)
        ]
    if finding.story:
        result["codeFlows"] = [_flow(finding)]
    if finding.edit is not None:
        result["fixes"] = [_fix(finding.edit)]
    return result


def _fix(edit: Edit) -> dict[str, Any]:
    region = {
        "startLine": edit.place.line,
        "startColumn": edit.place.column,
        "endLine": edit.place.line,
        "endColumn": edit.end_column,
    }
    return {
        "description": _message(f"Write {edit.text}" + ("" if edit.safe else " (not sure)")),
        "artifactChanges": [
            {
                "artifactLocation": _artifact(edit.place.file),
                "replacements": [{"deletedRegion": region, "insertedContent": {"text": edit.text}}],
            }
        ],
    }


def _flow(finding: Finding) -> dict[str, Any]:
    """Return the story as a code flow, with all sentences at the place of the finding."""
    place = _location(finding)
    steps = [
        {"location": {"message": _message(each), "physicalLocation": place}}
        for each in finding.story
    ]
    return {"message": _message("How it comes about"), "threadFlows": [{"locations": steps}]}


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


def _location(finding: Finding) -> dict[str, Any]:
    location = _physical(finding.place)
    if finding.place.line:
        location["region"]["endColumn"] = end_column(finding)
        if finding.excerpt:
            location["region"]["snippet"] = {"text": excerpt(finding)}
    return location


def _physical(place: Place) -> dict[str, Any]:
    location: dict[str, Any] = {"artifactLocation": _artifact(place.file)}
    if place.line:
        location["region"] = {"startLine": place.line, "startColumn": max(place.column, 1)}
    return location


def _artifact(name: str) -> dict[str, str]:
    path = Path(name)
    if path.is_absolute():
        return {"uri": path.as_uri()}
    posix = path.as_posix().encode("utf-8", "surrogateescape")
    return {"uri": quote(posix), "uriBaseId": _ROOT}


def _message(text: str) -> dict[str, str]:
    return {"text": text}
