"""Mistakes written from the documentation alone; `make mistakes` checks all of them."""

from __future__ import annotations

import pytest

from benchmarks.mistakes import ODD, Mistake, cases, checked, table

MISTAKES = {f"{case.kind}.{case.name}": case for case in cases()}
CORRECT = {f"{case.kind}.{case.name}": case for case in cases([ODD])}

SAMPLE = (
    "missions.structure.go",
    "missions.commands.reset",
    "missions.foreign.inch",
    "robots.charts.target",
    "pipes.networks.port",
    "projects.panels.command",
)
"""One of each kind of file, so that the table's counting is exercised in little time."""


def test_there_are_enough_of_them_and_each_edit_fits_its_base() -> None:
    assert len(MISTAKES) >= 600
    assert len(CORRECT) >= 140
    assert all(case.lines and case.why for case in MISTAKES.values())


@pytest.mark.parametrize("name", SAMPLE)
def test_a_mistake_is_reported_on_its_line(name: str) -> None:
    outcome = checked(MISTAKES[name])

    assert outcome.on_line, str(outcome)


@pytest.mark.parametrize("name", ["yaml.crlf", "panels.number_0", "projects.one_mission"])
def test_nothing_is_said_of_an_odd_but_correct_file(name: str) -> None:
    assert checked(CORRECT[f"{ODD}.{name}"]).found == []


def test_a_finding_on_another_line_or_in_no_file_is_not_on_the_line_of_the_mistake() -> None:
    [go] = [MISTAKES["missions.structure.go"]]
    elsewhere = Mistake(go.kind, go.name, go.path, go.files, frozenset({1}), go.why)

    outcomes = [checked(go), checked(elsewhere)]

    assert [each.answer for each in outcomes] == ["on its line", "elsewhere"]
    assert table(outcomes).splitlines()[-1].split() == ["all", "2", "50%", "1", "0"]
