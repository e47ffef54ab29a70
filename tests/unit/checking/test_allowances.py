"""Comments that allow a finding on their line."""

from __future__ import annotations

import pytest

from pirate_sm.checking.findings import Finding, Severity, allowances, settle
from pirate_sm.core.documents import Place


def found(line: int, code: str, file: str = "m.yaml") -> Finding:
    return Finding(code, Severity.ERROR, Place(file, line, 1), "something")


def settled(text: str, *findings: Finding) -> list[tuple[str, int, str]]:
    return [
        (each.code, each.place.line, each.allowed) for each in settle(findings, {"m.yaml": text})
    ]


def test_a_finding_is_allowed_on_its_line_with_its_reason() -> None:
    text = "a: b\nc: d  # pirate: allow step.impossible: tried on the block\n"

    assert settled(text, found(2, "step.impossible")) == [
        ("step.impossible", 2, "tried on the block")
    ]


def test_one_comment_allows_several_codes() -> None:
    text = "c: d # pirate: allow step.impossible, trigger.at_once: both are meant: yes\n"

    assert settled(text, found(1, "trigger.at_once"), found(1, "step.impossible")) == [
        ("trigger.at_once", 1, "both are meant: yes"),
        ("step.impossible", 1, "both are meant: yes"),
    ]


def test_nothing_is_allowed_on_another_line_of_another_code_or_in_another_file() -> None:
    text = "c: d  # pirate: allow step.impossible: because\ne: f\n"
    others = found(2, "step.impossible"), found(1, "step.unneeded")
    elsewhere = found(1, "step.impossible", "n.yaml")

    assert settled(text, *others, elsewhere) == [
        ("step.impossible", 2, ""),
        ("step.unneeded", 1, ""),
        ("step.impossible", 1, ""),
        ("allow.unused", 1, ""),
    ]


@pytest.mark.parametrize(
    "comment",
    [
        "# pirate: allow step.impossible",
        "# pirate: allow step.impossible:",
        "# pirate: allow step.impossible:   ",
        "# pirate: allow step.impossible because it is meant",
        "#pirate:allow step.impossible",
    ],
)
def test_without_a_reason_nothing_is_allowed(comment: str) -> None:
    assert settled(f"c: d  {comment}\n", found(1, "step.impossible")) == [
        ("step.impossible", 1, ""),
        ("allow.reason", 1, ""),
    ]


def test_a_comment_that_names_no_code_says_so() -> None:
    assert settled("c: d  # pirate: allow\n") == [("allow.reason", 1, "")]


def test_a_misspelt_code_is_told_with_the_one_that_was_meant() -> None:
    (fault,) = settle([], {"m.yaml": "c: d  # pirate: allow step.imposible: why not\n"})

    assert (fault.code, fault.suggestion) == ("allow.unused", "step.impossible")
    assert fault.excerpt[fault.place.column - 1 :].startswith("step.imposible")


@pytest.mark.parametrize("code", ["mission.name", "syntax", "allow.unused"])
def test_what_keeps_a_file_from_being_used_cannot_be_allowed(code: str) -> None:
    assert settled(f"c: d  # pirate: allow {code}: why not\n", found(1, code)) == [
        (code, 1, ""),
        ("allow.unused", 1, ""),
    ]


def test_a_block_text_takes_its_comment_on_its_first_line() -> None:
    text = (
        "cond: >-  # pirate: allow chart.guard_always: clearer so\n  In('a.b')\n  or true\nx: y\n"
    )

    assert [each.lines for each in allowances("m.yaml", text)] == [range(1, 4)]
    assert settled(text, found(3, "chart.guard_always"))[0][2] == "clearer so"


@pytest.mark.parametrize(
    "text",
    [
        'log: "say # pirate: allow step.impossible: no"\n',
        "log: 'say # pirate: allow step.impossible: no'\n",
        "log: |\n  say # pirate: allow step.impossible: no\n",
        "log: say# pirate: allow step.impossible\n",
    ],
)
def test_what_is_no_comment_allows_nothing(text: str) -> None:
    assert allowances("m.yaml", text) == ()


def test_comments_are_found_in_a_file_that_cannot_be_read() -> None:
    text = "a: [b\nc: d  # pirate: allow step.impossible: because\n"

    assert [each.code for each in allowances("m.yaml", text)] == ["step.impossible"]
