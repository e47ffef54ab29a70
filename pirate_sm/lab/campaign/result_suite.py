"""The results of a campaign as JUnit XML, for CI."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from pirate_sm.checking.reports.junit import count_cases, junit_text
from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.results import CampaignResult, CellResult


def as_junit(result: CampaignResult) -> str:
    """Return the result as a suite; a cell fails that is not as expected or lacks results."""
    name = visible(result.name)
    suite = Element("testsuite", name=name)
    for cell in result.cells:
        case = SubElement(suite, "testcase", name=visible(cell.name), classname=name, time="0")
        if cell.runs and not cell.good:
            kind = "bug" if cell.bugs else "expectation"
            what = ", ".join(cell.missed) or "an internal error"
            SubElement(case, "failure", type=kind, message=what).text = _body(cell)
        elif cell.incomplete:
            SubElement(case, "error", type="incomplete", message=cell.incomplete)
        elif not cell.runs:
            SubElement(case, "skipped", message="no runs")
        else:
            SubElement(case, "system-out").text = _body(cell)
    for left_out in result.left_out:
        case = SubElement(suite, "testcase", name=visible(left_out), classname=name, time="0")
        SubElement(case, "skipped", message="a cell before it is not as expected")
    count_cases(suite)
    return junit_text("pirate campaign", [suite])


def _body(cell: CellResult) -> str:
    lines = [
        f"{cell.summary}; expected {cell.expected}",
        *([cell.incomplete] if cell.incomplete else []),
    ]
    for cause in cell.causes:
        lines += [f"{cause.count} × {cause.verdict}: {cause.why}", cause.command]
    return visible("\n".join(lines), lines=True)
