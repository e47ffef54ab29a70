"""What other projects take from this repository for their own checks."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml
from pre_commit.clientlib import load_manifest

ROOT = Path(__file__).resolve().parents[1]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
BROKEN = "format: 1\nmission: m\nrobot: pirate_ii\nstart: a\nphases: {}\nends: {e: {succeed: ok}}\n"


def test_the_hook_checks_the_whole_project() -> None:
    (hook,) = load_manifest(str(ROOT / ".pre-commit-hooks.yaml"))

    assert (hook["id"], hook["entry"], hook["args"]) == ("pirate-check", "pirate check", ["."])
    assert hook["pass_filenames"] is False


@pytest.fixture
def runner(tmp_path: Path) -> Any:
    """Runs a step of the action as GitHub does, with this program for the installed one."""
    program = tmp_path / "runner" / "pirate" / "bin" / "pirate"
    program.parent.mkdir(parents=True)
    code = "from pirate_sm.cli.entry import main; main()"
    program.write_text(f"#!/bin/sh\nexec {sys.executable} -c '{code}' \"$@\"\n", encoding="utf-8")
    program.chmod(0o755)
    work = tmp_path / "work"
    work.mkdir()

    def run(name: str, **inputs: str) -> subprocess.CompletedProcess[str]:
        (step,) = (each for each in ACTION["runs"]["steps"] if each["name"] == name)
        given = {key: str(value["default"]) for key, value in ACTION["inputs"].items()} | inputs

        def filled(match: re.Match[str]) -> str:
            return given[match[1]]

        own = {
            key: re.sub(r"\$\{\{ inputs\.([a-z-]+) \}\}", filled, value)
            for key, value in step["env"].items()
        }
        env = os.environ | own
        env |= {"RUNNER_TEMP": str(tmp_path / "runner"), "PYTHONPATH": str(ROOT)}
        return subprocess.run(
            ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]],
            cwd=work, capture_output=True, text=True, check=False, env=env,
        )  # fmt: skip

    run.work = work  # type: ignore[attr-defined]
    return run


@pytest.mark.thorough
def test_the_action_shows_findings_and_fails(runner: Any) -> None:
    (runner.work / "a b.yaml").write_text(BROKEN, encoding="utf-8")
    (runner.work / "c.yaml").write_text(BROKEN, encoding="utf-8")

    result = runner("Check", paths="a b.yaml\nc.yaml\n")
    assert result.returncode == 1, result.stderr
    assert result.stdout.startswith("::error file=a b.yaml,line=5,")
    assert "::error file=c.yaml,line=5," in result.stdout


@pytest.mark.thorough
def test_the_action_writes_sarif_and_leaves_failing_to_the_check(runner: Any) -> None:
    (runner.work / "m.yaml").write_text(BROKEN, encoding="utf-8")

    assert runner("SARIF", sarif="out.sarif").returncode == 0
    assert '"version": "2.1.0"' in (runner.work / "out.sarif").read_text("utf-8")
    assert runner("SARIF", sarif="out.sarif", paths="nowhere.yaml").returncode != 0


@pytest.mark.thorough
def test_a_path_cannot_become_a_command_or_an_option(runner: Any) -> None:
    result = runner("Check", paths="--help\n$(touch owned)\n; touch owned\n")

    assert result.returncode == 2
    assert "there is no file or folder '--help'" in result.stderr
    assert not (runner.work / "owned").exists()
