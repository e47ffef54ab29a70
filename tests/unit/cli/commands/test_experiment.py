from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.lab.experiments import needed_extras

from ..conftest import NEWT


@pytest.fixture(autouse=True)
def without_mujoco(monkeypatch: pytest.MonkeyPatch) -> None:
    """The runs on the backend physics take seconds; they are tested where they are made."""
    monkeypatch.setattr(needed_extras, "find_spec", lambda module: None)


@pytest.mark.thorough
def test_the_thesis_stands_beside_ours_with_a_verdict_and_its_reason(
    pirate: Any, tmp_path: Path
) -> None:
    page, csv = tmp_path / "page.html", tmp_path / "rows.csv"

    told = pirate("experiment", "3c", "--seeds", "1", "-o", page, "--csv", csv)

    assert told.exit_code == 1, "its way is contradicted"
    assert "thesis about 2 cm (6-4, fig. 6-11), band 15 to 25 (one digit is printed" in told.stdout
    assert "ours 19.9" in told.stdout
    assert "assumed: by control.gain, control.speed, noise.thesis.speed; creep" in told.stdout
    assert "3a" not in {line.split()[0] for line in told.stdout.splitlines() if line.strip()}
    assert "Fig. 6-11" in page.read_text()
    assert "3c,odometry error with noise,about 2 cm,15 to 25,19.9" in csv.read_text()
    assert "3c on physics: not run, mujoco is not installed" in told.stdout
    assert "loops on physics" not in told.stdout


@pytest.mark.thorough
def test_every_verdict_is_there_for_programs_and_that_compensation_harms_is_contradicted(
    pirate: Any, tmp_path: Path
) -> None:
    asked = ("3c", "3d", "--seeds", "1", "--noise", "thesis", "--format", "json")
    told = pirate("experiment", *asked, "-o", tmp_path / "page.html")

    data = json.loads(told.stdout)
    assert sum(data["counts"].values()) == len(data["rows"])
    (harms,) = (row for row in data["rows"] if "compensation harms" in row["what"])
    assert harms["verdict"] == "contradicted"
    assert harms["reason"].startswith("3d = 3c in odometry: F = K_p (v_d + m g r sin a")
    assert harms["between"] == [-1000, -1]


def test_an_unknown_experiment_is_refused(pirate: Any) -> None:
    told = pirate("experiment", "3e")

    assert told.exit_code == 2
    assert "there is no experiment '3e'" in told.output


def test_an_unknown_noise_is_refused(pirate: Any) -> None:
    told = pirate("experiment", "3a", "--noise", "loud")

    assert told.exit_code == 2
    assert "--noise loud: expected one of clean, thesis" in told.output


def test_a_robot_without_experiments_is_refused(pirate: Any) -> None:
    told = pirate("experiment", "all", "--robot", NEWT)

    assert told.exit_code == 2
    assert "the robot has no experiments" in told.output
