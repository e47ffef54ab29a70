"""Mistakes written from the documentation alone; `make mistakes` checks all of them."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import chdir
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from representative import thorough_but

from benchmarks.mistakes import FILES, ODD, Mistake, cases, checked, table, written
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.reports.check_report import changes_of


@cache
def mistakes(file: str) -> dict[str, Mistake]:
    """The cases of a file, by their groups and names."""
    return {f"{case.kind}.{case.name}": case for case in cases([file])}


def mistake(name: str) -> Mistake:
    return mistakes(name.partition(".")[0])[name]


SAMPLE = (
    "missions.structure.go",
    "missions.commands.reset",
    "missions.foreign.inch",
    "missions.structure.resume_first",
    "missions.routes.back",
    "projects.campaigns.before_short",
    "projects.campaigns.defect_twice",
    "robots.charts.target",
    "pipes.networks.port",
    "projects.panels.command",
)
"""Some of each kind of file, so that the table's counting is exercised in little time."""


def test_there_are_enough_of_them_and_each_edit_fits_its_base() -> None:
    every = [case for file in FILES for case in mistakes(file).values()]
    assert len(every) >= 746
    assert len(mistakes(ODD)) >= 185
    assert all(case.lines and case.why for case in every)


SLOW = ("missions.routes.back", "projects.campaigns.before_short")

OF_SCENES = ("mission", "defect", "fault", "power_cut", "missing_recording")
"""What a scene names that is not there."""


@pytest.mark.parametrize(
    "name",
    thorough_but(
        [each for each in SAMPLE if each not in SLOW] + [f"projects.scenes.{OF_SCENES[0]}"],
        [*SAMPLE, *(f"projects.scenes.{each}" for each in OF_SCENES)],
    ),
)
def test_a_mistake_is_reported_on_its_line(name: str) -> None:
    outcome = checked(mistake(name))

    assert outcome.on_line, str(outcome)


@pytest.mark.parametrize("name", ["yaml.crlf", "panels.number_0", "projects.one_mission"])
def test_nothing_is_said_of_an_odd_but_correct_file(name: str) -> None:
    assert checked(mistake(f"{ODD}.{name}")).found == []


def test_a_finding_on_another_line_or_in_no_file_is_not_on_the_line_of_the_mistake() -> None:
    go = mistake("missions.structure.go")
    elsewhere = Mistake(go.kind, go.name, go.path, go.files, frozenset({1}), go.why)

    outcomes = [checked(go), checked(elsewhere)]

    assert [each.answer for each in outcomes] == ["on its line", "elsewhere"]
    assert table(outcomes).splitlines()[-1].split() == ["all", "2", "50%", "1", "0"]


def _key(finding: Finding) -> tuple[str, str, int, str]:
    return finding.code, finding.place.file, finding.place.line, finding.message


def _fixed_one_by_one(case: Mistake, folder: Path) -> list[str]:
    """Make each safe edit of a case alone; return their texts."""
    made = []
    with chdir(folder):
        written(case)
        report = check_paths([case.path])
        known = set(map(_key, report.open))
        for finding in report.open:
            for change in changes_of(replace(report, findings=(finding,)), ["."], unsafe=False):
                change.write()
                left = set(map(_key, check_paths([case.path]).open))
                Path(change.name).write_bytes(change.before.encode())

                assert _key(finding) not in left, case
                assert left <= known, case
                assert finding.edit is not None
                made.append(finding.edit.text)
    return made


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("missions.structure.do_text", ["[Brake]"]),
        ("missions.structure.do_commas", ["[Brake, ToggleLighting]"]),
        ("missions.structure.do_blanks", []),  # two commands, or a misspelt one?
        ("missions.structure.do_log", []),
        ("missions.structure.end_text", ["{succeed: success}"]),
        ("missions.parameters.list", ["{type: length, default: 200 mm}"]),
        ("missions.conditions.and", ["and"]),
        ("missions.conditions.and_unspaced", [" and "]),
        ("missions.conditions.not_unspaced", ["not "]),
        ("missions.conditions.and_space_and", []),
        ("missions.conditions.arrow", [">="]),
        ("missions.conditions.angle", []),  # which unit?
        ("missions.structure.key", []),  # a misspelt name is a guess
    ],
)
def test_a_safe_edit_removes_its_finding_and_causes_no_other(
    name: str, texts: Sequence[str], tmp_path: Path
) -> None:
    assert _fixed_one_by_one(mistake(name), tmp_path) == texts


@pytest.mark.thorough
@pytest.mark.timeout(600)
@pytest.mark.parametrize("file", FILES)
def test_safe_edits_of_the_corpus_do_too(file: str, tmp_path: Path) -> None:
    for name, case in mistakes(file).items():
        folder = tmp_path / name
        folder.mkdir()
        _fixed_one_by_one(case, folder)
