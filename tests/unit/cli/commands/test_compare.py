from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from ..conftest import NEWT


@pytest.fixture
def run(pirate_run: Any, tmp_path: Path) -> Any:
    def make(name: str, *arguments: str) -> Path:
        path = tmp_path / f"{name}.mcap"
        pirate_run(NEWT / "patrol.yaml", *arguments, "--quiet", "--record", path)
        return path

    return make


@pytest.mark.thorough
def test_seeds_and_options_that_differ_are_named_before_anything_else(
    pirate: Any, run: Any
) -> None:
    one, other = run("one", "--seed", "1"), run("other", "--seed", "2", "--set", "look=3 s")

    lines = pirate("compare", one, other).stdout.splitlines()

    assert lines[3].startswith("A and B take the same course; B takes 0.9 s longer than A, mostly")
    assert lines[5].split() == ["what", "differed", "A", "B"]
    assert lines[6].split() == ["seed", "1", "2"]
    assert lines[7].split() == ["parameter", "look", "2", "s", "3", "s"]
    assert lines[8] == ""


def test_folders_without_results_are_refused_with_what_is_expected(
    pirate: Any, run: Any, tmp_path: Path
) -> None:
    empty = tmp_path / "empty"
    empty.mkdir()

    for one, other in ((empty, empty), (run("one"), empty)):
        result = pirate("compare", one, other)
        assert result.exit_code == 2
        assert f"'{empty}' is a folder without results of a campaign" in result.stderr
        assert "name two recordings of runs (.mcap), or two folders with results" in result.stderr


def test_a_place_that_does_not_exist_is_named_and_not_the_other_one(
    pirate: Any, run: Any, tmp_path: Path
) -> None:
    missing, results = tmp_path / "missing", tmp_path / "results"
    results.mkdir()
    (results / "campaign.json").touch()

    for one, other in ((missing, results), (results, missing), (run("one"), missing)):
        result = pirate("compare", one, other)
        assert result.exit_code == 2
        assert result.stderr == f"there is no '{missing}'\n"


@pytest.mark.thorough
def test_runs_that_were_made_alike_say_so(pirate: Any, run: Any) -> None:
    one, other = run("one"), run("other")

    assert "the same seed, parameters and files" in pirate("compare", one, other).stdout


def test_of_equal_runs_one_sentence_says_that_their_signals_are_the_same(
    pirate: Any, run: Any
) -> None:
    result = pirate("compare", run("one"), run("other"))

    assert result.exit_code == 0
    assert result.stdout.rstrip().endswith("\n\nevery signal is the same in A and B")
    assert "largest differences" not in result.stdout
