"""Workflow commands as GitHub reads them."""

from __future__ import annotations

import re

from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.checking.reports.machine_readable import github_report

_COMMAND = re.compile(r"::(?P<command>\w+) (?P<properties>[^:]*)::(?P<data>.*)")


def read(line: str) -> tuple[str, dict[str, str], str]:
    """A command as the runner takes it apart: first at `::`, then at `,`, then unescaped."""
    match = _COMMAND.fullmatch(line)
    assert match is not None, line
    pairs = (each.partition("=") for each in match["properties"].split(","))
    properties = {name: unescaped(value, {"%3A": ":", "%2C": ","}) for name, _, value in pairs}
    return match["command"], properties, unescaped(match["data"], {})


def unescaped(text: str, more: dict[str, str]) -> str:
    for code, char in {"%0D": "\r", "%0A": "\n", **more, "%25": "%"}.items():
        text = text.replace(code, char)
    return text


def test_each_finding_stands_at_its_line(report: CheckReport) -> None:
    lines = github_report(report).splitlines()

    command, properties, data = read(lines[0])
    assert command == "error"
    assert properties == {
        "file": "missions/my mission.yaml", "line": "12", "endLine": "12", "col": "15",
        "endColumn": "24", "title": "step.maybe_impossible (error)",
    }  # fmt: skip
    assert data.splitlines()[:2] == ["RelaxRear can be refused: 50 %", "1. the mission begins"]
    assert [read(line)[0] for line in lines[1:4]] == ["warning", "notice", "error"]


def test_a_finding_of_a_whole_file_names_no_line(report: CheckReport) -> None:
    _, properties, _ = read(github_report(report).splitlines()[3])

    assert properties == {"file": "/tmp/gone.yaml", "title": "file (error)"}


def test_an_allowed_finding_is_counted_but_gets_no_annotation(report: CheckReport) -> None:
    text = github_report(report)

    assert "chart.trap" not in text
    assert text.endswith("1 allowed")


def test_text_from_a_file_cannot_begin_a_command(hostile: CheckReport) -> None:
    lines = github_report(hostile).split("\n")

    assert len(lines) == 2
    _, properties, data = read(lines[0])
    assert properties["file"] == hostile.findings[0].place.file
    assert data.startswith(hostile.findings[0].message)
