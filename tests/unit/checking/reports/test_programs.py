"""The reports for programs hold to their schemas."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from typing import Any

import jsonschema
import pytest
from late import late

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.checking.reports.junit import junit_report
from pirate_sm.checking.reports.machine_readable import json_report, sarif_report
from pirate_sm.core.documents import Place

from ..robots import ROOT

xmlschema = late("xmlschema")

SCHEMAS = ROOT / "tests" / "schemas"
OWN = json.loads((ROOT / "docs" / "schemas" / "check.schema.json").read_text("utf-8"))
SARIF = json.loads((SCHEMAS / "sarif-2.1.0.json").read_text("utf-8"))


@cache
def junit_schema() -> Any:
    return xmlschema.XMLSchema(str(SCHEMAS / "junit-10.xsd"))


@pytest.fixture
def every_code() -> CheckReport:
    """A report with a finding of each code."""
    return CheckReport(
        tuple(
            Finding(code, Severity[entry.severity.upper()], Place("a.yaml", 1, 1), entry.title)
            for code, entry in catalogue.entries().items()
        ),
        (),
    )


@pytest.fixture(params=["report", "clean", "hostile", "every_code"])
def any_report(request: pytest.FixtureRequest) -> CheckReport:
    return request.getfixturevalue(request.param)


def sarif(report: CheckReport) -> Any:
    return json.loads(sarif_report(report))


@pytest.mark.parametrize(("write", "schema"), [(json_report, OWN), (sarif_report, SARIF)])
def test_what_programs_read_is_as_its_schema_says(
    any_report: CheckReport, write: Callable[[CheckReport], str], schema: Any
) -> None:
    text = write(any_report)

    jsonschema.validate(json.loads(text), schema)
    assert text.isascii()


def test_json_holds_everything(report: CheckReport) -> None:
    data = json.loads(json_report(report))

    assert data["summary"] == {"error": 2, "warning": 1, "possible": 1, "allowed": 1, "fixed": 0}
    first = data["findings"][0]
    assert (first["line"], first["column"], first["end_column"]) == (12, 15, 24)
    assert first["story"][0] == "the mission begins"
    assert first["related"][0]["message"] == "called from here"
    assert first["edit"] == {
        "file": "missions/my mission.yaml", "line": 12, "column": 15, "end_line": 12,
        "end_column": 24, "replacement": "RelaxFront", "safe": False,
    }  # fmt: skip
    assert data["findings"][1]["edit"] is None
    assert data["findings"][3]["allowed"] == "it ends, here"


def test_sarif_names_its_schema_and_where_the_program_is_told_of(report: CheckReport) -> None:
    log = sarif(report)
    driver = log["runs"][0]["tool"]["driver"]

    assert log["$schema"].endswith("/sarif-2.1.0.json")
    assert driver["informationUri"] == f"pkg:pypi/pirate-sm@{driver['version']}"


def test_sarif_has_the_change_that_removes_a_finding(report: CheckReport) -> None:
    first, second, *_ = sarif(report)["runs"][0]["results"]

    [change] = first["fixes"][0]["artifactChanges"]
    assert change == {
        "artifactLocation": {"uri": "missions/my%20mission.yaml", "uriBaseId": "%SRCROOT%"},
        "replacements": [
            {
                "deletedRegion": {
                    "startLine": 12, "startColumn": 15, "endLine": 12, "endColumn": 24,
                },
                "insertedContent": {"text": "RelaxFront"},
            }
        ],
    }  # fmt: skip
    assert "fixes" not in second


def test_sarif_shows_the_place_the_story_and_what_is_allowed(report: CheckReport) -> None:
    (run,) = sarif(report)["runs"]
    first, second, third, allowed, whole = run["results"]

    place = first["locations"][0]["physicalLocation"]
    assert place["artifactLocation"] == {
        "uri": "missions/my%20mission.yaml", "uriBaseId": "%SRCROOT%"
    }  # fmt: skip
    region = place["region"]
    assert (region["startLine"], region["startColumn"], region["endColumn"]) == (12, 15, 24)
    (thread,) = first["codeFlows"][0]["threadFlows"]
    assert [each["location"]["message"]["text"] for each in thread["locations"]] == [
        "the mission begins", "RelaxRear is refused:\nwheels turn",
    ]  # fmt: skip
    assert [each["level"] for each in (first, second, third)] == ["error", "warning", "note"]
    assert allowed["suppressions"] == [{"kind": "inSource", "justification": "it ends, here"}]
    assert second["suppressions"] == []
    location = whole["locations"][0]["physicalLocation"]
    assert location == {"artifactLocation": {"uri": "file:///tmp/gone.yaml"}}


def test_sarif_explains_the_rules_that_it_uses(report: CheckReport) -> None:
    (run,) = sarif(report)["runs"]
    rules = run["tool"]["driver"]["rules"]

    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
    assert rules[0]["shortDescription"]["text"] == "A command is refused as impossible on some path"
    assert "brake" not in rules[0]["help"]["text"]


def test_sarif_knows_a_finding_again_on_another_line_and_tells_equal_ones_apart() -> None:
    def prints(*lines: int) -> list[str]:
        findings = [
            Finding("chart.trap", Severity.WARNING, Place("a.yaml", line, 1), "m", excerpt="x")
            for line in lines
        ]
        results = sarif(CheckReport(tuple(findings), ()))["runs"][0]["results"]
        return [each["partialFingerprints"]["finding/v1"] for each in results]

    assert prints(3, 9) == prints(4, 11)
    assert len(set(prints(3, 9))) == 2


def test_junit_is_as_its_schema_says(any_report: CheckReport) -> None:
    junit_schema().validate(junit_report(any_report, Severity.WARNING))


REPORTS = [json_report, sarif_report, lambda report: junit_report(report, Severity.ERROR)]


@pytest.mark.parametrize("written", REPORTS, ids=["json", "sarif", "junit"])
def test_a_report_for_programs_hides_nothing_on_a_terminal(
    written: Callable[[CheckReport], str], hostile: CheckReport
) -> None:
    assert all(line.isprintable() for line in written(hostile).split("\n"))


@pytest.mark.parametrize(("fail_on", "failures"), [(Severity.ERROR, "2"), (Severity.WARNING, "3")])
def test_junit_fails_where_the_check_fails(
    report: CheckReport, fail_on: Severity, failures: str
) -> None:
    data = junit_schema().to_dict(junit_report(report, fail_on))

    assert (data["@tests"], data["@failures"]) == ("6", failures)
    suites = {each["@name"]: each for each in data["testsuite"]}
    assert suites["clean.yaml"]["testcase"][0]["@name"] == "no findings"
    assert suites["a.yaml"]["@skipped"] == "1"
    assert suites["/tmp/gone.yaml"]["testcase"][0]["failure"][0]["@type"] == "file"


def test_a_line_of_a_hostile_file_does_not_fill_the_report() -> None:
    found = Finding("kind", Severity.ERROR, Place("a", 1, 1), "m", excerpt="x" * 1_000_000)
    report = CheckReport((found,), ())

    for text in (json_report(report), sarif_report(report), junit_report(report, Severity.ERROR)):
        assert len(text) < 10_000
