"""Reports as workflow commands of GitHub, which show each finding at its line."""

from __future__ import annotations

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, end_column
from pirate_sm.checking.reports.text import summary

_COMMANDS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.POSSIBLE: "notice"}


def github_report(report: CheckReport) -> str:
    """Return one command for each finding that is not allowed, followed by the summary."""
    return "\n".join([*map(_command, report.open), _data(summary(report))])


def _command(finding: Finding) -> str:
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
    given = ",".join(f"{name}={_property(value)}" for name, value in properties.items())
    return f"::{_COMMANDS[finding.severity]} {given}::{_data(_message(finding))}"


def _message(finding: Finding) -> str:
    entry = catalogue.entry_of(finding.code)
    lines = [finding.message]
    lines += [f"{number}. {each}" for number, each in enumerate(finding.story, start=1)]
    if finding.suggestion:
        lines.append(f"Did you mean '{finding.suggestion}'?")
    lines += [line for line in (entry.why, finding.fix or entry.fix) if line]
    return "\n".join(lines)


def _data(text: str) -> str:
    """Return a message escaped so that it cannot contain a command."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
