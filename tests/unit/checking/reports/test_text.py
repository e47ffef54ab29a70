"""The report for people."""

from __future__ import annotations

import pytest

from pirate_sm.checking.findings import Finding, Severity
from pirate_sm.checking.reports.check_report import CheckReport, end_column, marked
from pirate_sm.checking.reports.text import explained, listed, text_report
from pirate_sm.core.documents import Place


def plain(_: str, text: str) -> str:
    return text


def at(column: int, excerpt: str) -> Finding:
    return Finding(
        "step.impossible", Severity.ERROR, Place("m.yaml", 1, column), "m", excerpt=excerpt
    )


def test_a_finding_says_what_where_why_and_how_to_mend_it(report: CheckReport) -> None:
    text = text_report(report, plain)

    assert text.startswith(
        "missions/my mission.yaml:12:15: error [step.maybe_impossible]"
        " RelaxRear can be refused: 50 %\n"
        "  12 | - {command: RelaxRear, if: 'speed > 2 m/s'}  # 100 %, really: ünusual\n"
        "     |             ^^^^^^^^^\n"
        "  missions/called.yaml:3:1: called from here\n"
        "  how it comes about:\n"
        "    1. the mission begins\n"
        "    2. RelaxRear is refused: wheels turn\n"
        "  why:  It works until a trigger, failure or fault takes the other path.\n"
        "  fix:  did you mean 'RelaxFront'? brake first\n"
        "  example: loss_1\n"
    )
    assert "/tmp/gone.yaml: error [file] there is no such file\n  why:" in text


def test_what_is_allowed_is_listed_with_its_reason(report: CheckReport) -> None:
    text = text_report(report, plain)

    assert "allowed:\n  a.yaml:4:3 chart.trap\n    trap; because it ends, here\n" in text
    assert text.endswith("\n1 pipe, 2 missions checked: 2 errors, 1 warning, 1 possible, 1 allowed")


def test_a_clean_report_is_one_line(clean: CheckReport) -> None:
    assert text_report(clean, plain) == "1 pipe checked: no findings"
    assert text_report(CheckReport((), ()), plain) == "nothing checked: no findings"


def test_every_text_from_a_file_is_painted(hostile: CheckReport) -> None:
    text = text_report(hostile, lambda _, text: text.replace("\x1b", "?"))

    assert "\x1b" not in text


def test_every_severity_has_its_colour(report: CheckReport) -> None:
    text = text_report(report, lambda role, text: f"<{role}>{text}")

    for severity in ("error", "warning", "possible"):
        assert f"<{severity}>{severity}" in text


@pytest.mark.parametrize(
    ("column", "excerpt", "word"),
    [
        (5, "do: [ClampFront, x]", "["),
        (6, "do: [ClampFront, x]", "ClampFront"),
        (7, "when: 'a > b' # c", "'a > b'"),
        (7, 'when: "a \\" b" # c', '"a \\" b"'),
        (4, "go $give_up x", "$give_up"),
        (9, "at: 100 % ", "%"),
        (5, "at: 12.5 mm", "12.5"),
        (99, "short", ""),
    ],
)
def test_a_word_or_a_quoted_text_is_marked(column: int, excerpt: str, word: str) -> None:
    finding = at(column, excerpt)

    assert end_column(finding) == column + max(len(word), 1)
    shown = marked(finding)
    assert shown is not None
    line, under = shown
    start, end = under.index("^"), len(under)
    assert line[start:end] == word


@pytest.mark.parametrize("column", [1, 50, 150, 151, 900, 995])
def test_of_a_long_line_the_part_around_the_place_is_shown(column: int) -> None:
    excerpt = "".join(f"{n:04}|" for n in range(200))
    shown = marked(at(column, excerpt))

    assert shown is not None
    assert len(shown.line) <= 100
    assert len(shown.under) <= 100
    here = shown.under.index("^")
    assert shown.line[here] == excerpt[column - 1]


def test_without_a_line_nothing_is_marked() -> None:
    assert marked(at(1, "")) is None
    assert marked(at(1, "   ")) is None


def test_a_code_is_explained_with_examples() -> None:
    text = explained("step.unneeded")

    assert text.startswith("step.unneeded (error): A command is refused as unneeded")
    assert "Wrong:\n  do: [ClampFront, ClampRear, ClampFront]\n" in text
    assert "# pirate: allow step.unneeded: <reason>" in text
    assert "cannot be allowed" in explained("syntax")
    assert "\nDecided by: the text of the file\nNot decided: whether" in explained("syntax")


def test_a_fault_is_explained() -> None:
    assert explained("sensor.silent").splitlines() == [
        "sensor.silent (fault): a board does not report, or a sensor has no value",
        "",
        "How it is seen: the engine judges what the sensors show, on every backend alike.",
        "A mission can handle it: on_fault: [{fault: sensor.silent, then: continue}]",
    ]
    assert "No mission can handle it" in explained("link.lost")


def test_a_code_of_a_finding_and_a_fault_is_explained_as_both() -> None:
    text = explained("rule.violated")

    assert "rule.violated (error): A safety rule of the robot can be violated" in text
    assert "rule.violated (fault): a safety rule of the robot is broken, or would be" in text


def test_every_code_is_listed_by_group() -> None:
    lines = listed().splitlines()

    assert lines[0] == "Missions, step by step"
    assert any(line.startswith("  unknown-key ") for line in lines)
    assert "  motion.unasked " in "\n".join(lines)
