"""The result of a campaign as JUnit XML: a case for each cell."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement, indent, tostring

from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.results import CampaignResult, CellResult


def as_junit(result: CampaignResult) -> str:
    """Return the result as a suite that fails where a cell is not as expected."""
    name = visible(result.name)
    suite = Element("testsuite", name=name)
    for cell in result.cells:
        case = SubElement(suite, "testcase", name=visible(cell.name), classname=name, time="0")
        if not cell.runs:
            SubElement(case, "skipped", message="no runs")
        elif cell.good:
            SubElement(case, "system-out").text = _body(cell)
        else:
            kind = "bug" if cell.bugs else "expectation"
            what = ", ".join(cell.missed) or "an internal error"
            SubElement(case, "failure", type=kind, message=what).text = _body(cell)
    for left_out in result.left_out:
        case = SubElement(suite, "testcase", name=visible(left_out), classname=name, time="0")
        SubElement(case, "skipped", message="a cell before it is not as expected")
    bad = sum(not cell.good for cell in result.cells)
    suite.attrib |= {
        "tests": str(len(suite)),
        "failures": str(bad),
        "errors": "0",
        "skipped": str(sum(1 for _ in suite.iter("skipped"))),
    }
    sums = {key: suite.attrib[key] for key in ("tests", "failures", "errors")}
    root = Element("testsuites", {"name": "pirate campaign", **sums})
    root.append(suite)
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _body(cell: CellResult) -> str:
    lines = [
        f"{cell.summary}; expected {cell.expected}",
        *([cell.incomplete] if cell.incomplete else []),
    ]
    for cause in cell.causes:
        lines += [f"{cause.count} × {cause.verdict}: {cause.why}", cause.command]
    return visible("\n".join(lines), lines=True)
