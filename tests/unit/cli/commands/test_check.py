"""`pirate check` and `pirate explain` as somebody calls them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from checking.small_missions import MISSION

from pirate_sm.cli.commands import check
from pirate_sm.cli.options.checks import CheckOptions
from pirate_sm.loading.robot import load_robot

from ..conftest import ROOT

WARNED = MISSION.replace("ends:", "  lost: {go: e}\nends:")


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def warned(here: Path) -> Path:
    """A mission with a warning and nothing worse."""
    file = here / "m.yaml"
    file.write_text(WARNED, encoding="utf-8")
    return file


@pytest.fixture
def broken(here: Path) -> Path:
    """A mission with an error."""
    file = here / "b.yaml"
    file.write_text(WARNED.replace("ClampFront", "ClampFont"), encoding="utf-8")
    return file


def test_all_shipped_files_are_clean_even_of_warnings(
    pirate: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    load_robot.cache_clear()  # its files have the names that they had in another folder
    result = pirate("check", "--fail-on", "warning")

    assert (result.exit_code, result.stderr) == (0, "")
    assert result.stdout == (
        "1 robot, 1 chart, 17 pipes, 1 panel, 26 missions checked in "
        "hardware_profiles, sequences, panels: no findings\n"
    )


def test_a_broken_mission_in_a_folder_that_is_no_project_is_no_false_green(
    pirate: Any, broken: Path
) -> None:
    """The shipped files were checked in its place."""
    result = pirate("check")

    assert result.exit_code == 1
    assert "mission.command" in result.stdout
    assert "\n1 mission checked in .: 1 error" in result.stdout


@pytest.mark.parametrize("paths", [(), ("empty",)])
def test_where_there_is_nothing_to_check_nothing_has_passed(
    pirate: Any, here: Path, paths: tuple[str, ...]
) -> None:
    (here / "empty").mkdir()
    result = pirate("check", *paths)

    assert result.exit_code == 2
    assert "there is no robot, mission or pipe in this folder" in result.stdout


def test_a_finding_fails_the_check_from_its_severity_on(
    pirate: Any, warned: Path, broken: Path
) -> None:
    assert pirate("check", warned).exit_code == 0
    assert pirate("check", warned, "--fail-on", "warning").exit_code == 1
    result = pirate("check", broken)
    assert result.exit_code == 1
    assert "b.yaml:6:12: error [mission.command] there is no command 'ClampFont'" in result.stdout
    assert "did you mean 'ClampFront'?" in result.stdout


@pytest.mark.parametrize(
    "arguments",
    [
        ["nowhere.yaml"],
        ["m.yaml", "--robot", "pirate_3"],
        ["m.yaml", "--pipe", "straight_13"],
        ["m.yaml", "--set", "speed=1 m/s"],
        ["m.yaml", "--set", "speed"],
        ["m.yaml", "--format", "html"],
        ["m.yaml", "--fail-on", "never"],
    ],
)
def test_what_does_not_fit_is_refused(pirate: Any, warned: Path, arguments: list[str]) -> None:
    result = pirate("check", *arguments)

    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr


def test_another_robot_and_pipe_are_taken(pirate: Any, warned: Path) -> None:
    assert pirate("check", warned, "--pipe", "mitre_90", "--robot", "pirate_ii").exit_code == 0
    newt = ROOT / "tests" / "robots" / "newt"
    result = pirate("check", warned, "--robot", newt)
    assert result.exit_code == 1
    assert "there is no command 'ClampFront'" in result.stdout


@pytest.mark.parametrize(
    ("name", "begin"),
    [
        ("json", '{\n "format": 1'),
        ("sarif", '{\n "$schema": "'),
        ("junit", '<?xml version="1.0"'),
        ("github", "::error file=b.yaml,line=6,endLine=6,col=12,endColumn=21,title="),
    ],
)
def test_every_format_is_written_with_the_same_exit_code(
    pirate: Any, broken: Path, name: str, begin: str
) -> None:
    result = pirate("check", broken, "--format", name)

    assert result.exit_code == 1
    assert result.stdout.startswith(begin)


def test_a_terminal_is_coloured_and_nothing_else_is(
    capsys: pytest.CaptureFixture[str], broken: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = CheckOptions(paths=[str(broken)])
    check.run_check(options)
    assert "\x1b" not in "".join(capsys.readouterr())

    monkeypatch.setattr(check, "is_terminal", lambda _: True)
    monkeypatch.delenv("NO_COLOR", raising=False)
    check.run_check(options)
    said = capsys.readouterr()
    assert "\x1b[1;31merror\x1b[0m" in said.out
    assert "checking 1/1 b.yaml" in said.err

    monkeypatch.setenv("NO_COLOR", "1")
    check.run_check(options)
    assert "\x1b" not in capsys.readouterr().out


def test_text_of_a_file_cannot_control_the_terminal(pirate: Any, here: Path) -> None:
    name = "x\x1b]0;owned\x07.yaml"
    (here / name).write_text(WARNED.replace("ClampFront", '"\\e[2J"'), encoding="utf-8")

    for form in ("text", "json", "github", "sarif", "junit"):
        result = pirate("check", ".", "--format", form)
        assert result.exit_code == 1
        assert not {"\x1b", "\x07"} & set(result.output)


def test_a_name_that_is_no_text_is_shown_all_the_same(here: Path) -> None:
    (here / b"m\xff.yaml".decode("utf-8", "surrogateescape")).write_text("mission: 1\nphases: 2\n")

    for form in ("text", "json", "github", "sarif", "junit"):
        code = "from pirate_sm.cli.entry import main; main()"
        ran = subprocess.run(
            [sys.executable, "-c", code, "check", ".", "--format", form],
            capture_output=True, check=False, env={"PYTHONPATH": str(ROOT), "PYTHONUTF8": "1"},
        )  # fmt: skip
        assert (ran.returncode, ran.stderr) == (1, b""), form
        ran.stdout.decode("utf-8")


def test_a_fault_of_the_check_is_a_finding_or_with_debug_a_traceback(
    pirate: Any, warned: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("lost")

    monkeypatch.setattr("pirate_sm.checking.project.check_project.check_mission", fail)

    result = pirate("check", warned)
    assert (result.exit_code, "check.failed" in result.stdout) == (1, True)
    result = pirate("check", warned, "--debug")
    assert (result.exit_code, "Traceback" in result.stderr) == (4, True)


def test_a_code_is_explained(pirate: Any) -> None:
    result = pirate("explain", "trigger.at_once")

    assert result.exit_code == 0
    assert "Why it matters: The wait waits for nothing." in result.stdout


def test_a_misspelt_code_is_understood(pirate: Any) -> None:
    result = pirate("explain", "trigger.at_one")
    assert result.exit_code == 2
    assert "did you mean 'trigger.at_once'?" in result.stderr
    assert "lists them all" in pirate("explain", "quite different").stderr


def test_without_a_code_all_are_listed(pirate: Any) -> None:
    result = pirate("explain")

    assert result.exit_code == 0
    for code in ("step.impossible", "chart.trap", "geometry.too_close", "unknown-key"):
        assert f"  {code} " in result.stdout


def test_json_is_one_object(pirate: Any, broken: Path) -> None:
    data = json.loads(pirate("check", broken, "--format", "json").stdout)

    assert data["files"] == [{"file": "b.yaml", "kind": "mission"}]
