"""Counterexamples as files: each really runs into its finding."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.file_part import Wishes
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.reports.check_report import CheckReport
from pirate_sm.cli.entry import only_run
from pirate_sm.core.errors import UsageError

BAD = """\
format: 1
mission: bad
robot: pirate_ii
parameters: {give_up: {type: duration, default: 5 s, min: 1 s, max: 9 s}}
start: enter
phases:
  enter:
    do: [ClampRear, ClampFront, RelaxRear]
    wait:
      - {when: detector == close, held: 1 s, go: next}
      - {operator: back, go: back}
    within: {time: $give_up, go: lost}
  next: {do: [RelaxFront], go: lost}
  back: {do: [ClampFront], go: done}
on_failure: lost
ends:
  done: {succeed: ok}
  lost: {fail: "lost: {cause}"}
"""


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.yaml").write_text(BAD, encoding="utf-8")
    return tmp_path


def checked(*paths: str, **wishes: Any) -> CheckReport:
    return check_paths(paths, Wishes(counterexamples=Path("out"), **wishes))


def command(finding: Finding) -> list[str]:
    """What the head of the script says to run."""
    lines = Path(finding.example).read_text("utf-8").splitlines()
    (line,) = (each for each in lines if each.startswith("# pirate-run "))
    return shlex.split(line.removeprefix("# pirate-run "))


def test_every_finding_with_a_course_of_events_is_written_and_runs_into_it() -> None:
    findings = checked("bad.yaml").open

    assert [each.code for each in findings] == ["step.impossible", "step.unneeded"]
    assert len({each.example for each in findings}) == 2
    for finding in findings:
        result = CliRunner().invoke(only_run(), [*command(finding), "--plain"])
        line = f"{finding.place.line}:{finding.place.column}"
        reason = "impossible" if finding.code == "step.impossible" else "unneeded"
        assert result.exit_code == 1
        assert any(
            f"refused: {reason}" in said and said.endswith(f".yaml:{line})")
            for said in result.stdout.splitlines()
        )


def test_the_command_has_the_options_of_the_check() -> None:
    (first, *_) = checked("bad.yaml", pipe="mitre_90", settings={"give_up": "2 s"}).open

    assert command(first)[-4:] == ["--pipe", "mitre_90", "--set", "give_up=2 s"]


def test_files_of_one_name_do_not_overwrite_each_other(here: Path) -> None:
    for folder in ("a", "b"):
        (here / folder).mkdir()
        (here / folder / "bad.yaml").write_text(BAD, encoding="utf-8")

    examples = [each.example for each in checked("a", "b").open]

    assert len(set(examples)) == 4
    assert all(Path(each).is_file() for each in examples)


def test_what_is_allowed_has_none(here: Path) -> None:
    text = BAD.replace(
        "[RelaxFront], go: lost}", "[RelaxFront], go: lost}  # pirate: allow step.impossible: so"
    )
    (here / "bad.yaml").write_text(text, encoding="utf-8")

    assert [bool(each.example) for each in checked("bad.yaml").findings] == [False, True]


def test_a_mission_that_does_not_load_has_none(here: Path) -> None:
    text = BAD.replace("RelaxRear]", "RelaxRear, ClampFont]")
    (here / "bad.yaml").write_text(text, encoding="utf-8")

    assert not any(each.example for each in checked("bad.yaml").findings)
    assert not (here / "out").exists()


def test_nothing_is_written_unless_asked_for(here: Path) -> None:
    assert not any(each.example for each in check_paths(["bad.yaml"]).findings)
    assert sorted(each.name for each in here.iterdir()) == ["bad.yaml"]


def test_a_folder_that_cannot_be_written_is_said(here: Path) -> None:
    (here / "out").write_text("a file", encoding="utf-8")

    with pytest.raises(UsageError, match="'out' cannot be written"):
        checked("bad.yaml")
