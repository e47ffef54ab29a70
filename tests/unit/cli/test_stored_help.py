"""Help texts come from files where these fit, and from the options where they do not."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pirate_sm.cli.start import print_stored_help

from .conftest import ROOT

HEAVY = {"cv2", "numpy", "pydantic", "rich", "statemachine", "yaml"}
CODE = (
    "import atexit, sys; bare = set(sys.modules); from pirate_sm.cli.start import {main}; "
    "sys.argv[0] = '{program}'\n"
    "atexit.register(lambda: print(*set(sys.modules) - bare, sep=chr(10), file=sys.stderr))\n"
    "{main}()"
)


class Full(io.StringIO):
    """An output on a disk that is full."""

    encoding = "utf-8"  # type: ignore[assignment]

    def flush(self) -> None:
        raise OSError(errno.ENOSPC, "")


MOST_OF_A_CHECK = 187
"""Our modules that checking a mission imports."""


def imported(line: str, code: int = 0, **environment: str) -> tuple[str, set[str]]:
    """Return what a command line prints, and the modules that it imports."""
    program, *arguments = line.split()
    main = "run_main" if program == "pirate-run" else "main"
    ran = subprocess.run(
        [sys.executable, "-c", CODE.format(main=main, program=program), *arguments],
        capture_output=True,
        check=False,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8", **environment},
    )
    assert ran.returncode == code
    return ran.stdout, set(ran.stderr.split())


@pytest.mark.parametrize(
    "line", ["pirate --help", "pirate run --help", "pirate-run -h", "pirate new robot -h"]
)
def test_help_imports_hardly_anything(line: str) -> None:
    told, modules = imported(line, COLUMNS="80")

    assert told.startswith(f"Usage: {line.rpartition(' ')[0]} ")
    assert len(modules) < 30
    assert not modules & {*HEAVY, "typer", "pirate_sm.cli.entry"}


@pytest.mark.parametrize("line", ["pirate --help", "pirate run --help", "pirate-run -h"])
def test_help_for_a_narrow_terminal_is_laid_out_and_imports_no_models(line: str) -> None:
    told, modules = imported(line, COLUMNS="60")

    assert told.startswith(f"Usage: {line.rpartition(' ')[0]} ")
    wide, _ = imported(line, COLUMNS="80")
    assert max(map(len, told.splitlines())) <= 60 < max(map(len, wide.splitlines()))
    assert "typer" in modules
    assert not modules & HEAVY - {"pydantic"}  # which typer itself imports


@pytest.mark.thorough
def test_a_check_of_a_mission_imports_only_what_its_files_need() -> None:
    """The number may only fall (decision 122)."""
    told, modules = imported("pirate check sequences/drive_on.yaml", COLUMNS="80")

    assert "1 mission checked" in told
    ours = [each for each in modules if each.split(".")[0] == "pirate_sm"]
    assert len(ours) <= MOST_OF_A_CHECK


@pytest.mark.thorough
def test_a_line_that_was_read_before_is_read_without_its_library(tmp_path: Path) -> None:
    line, place = "pirate-run drive_on --no-record --json", {"PIRATE_SM_CACHE": str(tmp_path)}
    first, read = imported(line, **place)
    again, kept = imported(line, **place)

    assert again == first
    assert read - kept >= {"typer", "pirate_sm.checking.mission.check_mission"}
    assert not kept & {"typer", "pirate_sm.checking.exploring.explore"}


def test_a_line_that_may_reach_a_robot_is_always_read(tmp_path: Path) -> None:
    for _ in range(2):
        _, modules = imported(
            "pirate-run drive_on --backend nonsense --no-record", 2, PIRATE_SM_CACHE=str(tmp_path)
        )
    assert "typer" in modules


def test_a_command_imports_no_other_commands_options() -> None:
    _, modules = imported("pirate explain --help", COLUMNS="60")

    assert "pirate_sm.cli.options.checks" in modules
    assert "pirate_sm.cli.options.devices" not in modules


@pytest.mark.parametrize(
    "arguments",
    [
        ["pirate"],
        ["pirate", "run"],
        ["pirate", "run", "m.yaml", "--help"],
        ["pirate", "nonsense", "--help"],
        ["pirate", "../../../etc/passwd", "--help"],
        ["another", "--help"],
        [],
    ],
)
def test_what_is_not_stored_is_not_printed(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert not print_stored_help(arguments)
    assert capsys.readouterr().out == ""


def test_an_output_that_cannot_be_written_is_left_to_the_slow_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(sys, "stdout", Full())
    assert not print_stored_help(["pirate", "--help"])
