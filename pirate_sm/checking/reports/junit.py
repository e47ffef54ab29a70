"""JUnit XML, which build servers read: the report of a check, and the frame of any report."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from pirate_sm.checking import catalogue
from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, excerpt
from pirate_sm.core.visible import visible


def junit_report(report: CheckReport, fail_on: Severity) -> str:
    """Return the report as suites that fail if the check fails.

    Args:
        report: The report.
        fail_on: Findings below this severity are cases that pass, with a note.
    """
    by_file: dict[str, list[Finding]] = {file.name: [] for file in report.files}
    for finding in report.findings:
        by_file.setdefault(finding.place.file, []).append(finding)
    suites = [_suite(file, found, fail_on) for file, found in by_file.items()]
    return junit_text("pirate check", suites)


def junit_text(name: str, suites: Sequence[Element]) -> str:
    """Return counted suites as JUnit XML, under a common name."""
    root = Element("testsuites", name=name)
    for key in ("tests", "failures", "errors"):
        root.set(key, str(sum(int(each.attrib[key]) for each in suites)))
    root.extend(suites)
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode")


def count_cases(suite: Element) -> None:
    """Write into a suite how many cases it has, and how many of them failed or were left out."""
    suite.attrib |= {
        "tests": str(len(suite)),
        "failures": str(sum(case.find("failure") is not None for case in suite)),
        "errors": str(sum(case.find("error") is not None for case in suite)),
        "skipped": str(sum(case.find("skipped") is not None for case in suite)),
    }


def _suite(file: str, findings: Iterable[Finding], fail_on: Severity) -> Element:
    suite = Element("testsuite", name=_legal(file))
    for finding in findings:
        _case(suite, finding, fail_on)
    if not len(suite):
        SubElement(suite, "testcase", name="no findings", classname=_legal(file), time="0")
    count_cases(suite)
    suite.set("time", "0")
    return suite


def _case(suite: Element, finding: Finding, fail_on: Severity) -> None:
    place = finding.place
    where = f":{place.line}:{place.column}" if place.line else ""
    name = f"{finding.code}{where} {finding.message}"
    case = SubElement(suite, "testcase", name=_legal(name), classname=_legal(place.file), time="0")
    if finding.allowed:
        SubElement(case, "skipped", message=_legal(f"allowed: {finding.allowed}"))
    elif finding.severity >= fail_on:
        failure = SubElement(case, "failure", type=finding.code, message=_legal(finding.message))
        failure.text = _legal(_body(finding))
    else:
        SubElement(case, "system-out").text = _legal(f"{finding.severity.word}\n{_body(finding)}")


def _body(finding: Finding) -> str:
    entry = catalogue.entry_of(finding.code)
    lines = [f"{finding.place}: {finding.message}", excerpt(finding)]
    lines += [f"{number}. {each}" for number, each in enumerate(finding.story, start=1)]
    lines += [f"did you mean '{finding.suggestion}'?" if finding.suggestion else ""]
    lines += [entry.why, finding.fix or entry.fix]
    return "\n".join(line for line in lines if line)


def _legal(text: str) -> str:
    """Return the text with invisible and illegal XML characters escaped."""
    return visible(text, lines=True)
