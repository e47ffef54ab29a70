"""`--fidelity fast`: it is said before the run, kept with it, and refused where there is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core.loading import load_mission
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.run_facts import about_run
from pirate_sm.views.report.run_list import listed

from .conftest import NEWT

PATROL = NEWT / "patrol.yaml"


def test_a_fast_run_says_so_and_so_does_its_recording(
    pirate_run: Any, pirate: Any, tmp_path: Path
) -> None:
    file = tmp_path / "run.mcap"

    told = pirate_run(PATROL, "--fidelity", "fast", "--record", file)

    assert told.exit_code == 0
    assert "sim (seed 0, fast)" in told.stdout
    assert "fast: 2 of 4 iterations" in told.stdout
    replayed = pirate("replay", file)
    assert replayed.exit_code == 0
    assert "on sim (fast)" in replayed.stdout
    recording = read_recording(file)
    assert recording.header.options["fidelity"] == "fast"
    assert listed(recording, "").conditions == ("fast",)
    about = about_run(recording.header, load_mission(PATROL))
    assert "fast" in about.where
    assert ("fidelity", "fast") in about.facts


def test_a_usual_run_says_nothing_of_it(pirate_run: Any) -> None:
    told = pirate_run(PATROL, "--no-record")

    assert told.exit_code == 0
    assert "iterations" not in told.stdout
    assert "(seed 0)" in told.stdout


@pytest.mark.parametrize("backend", ["physics", "trace"])
def test_a_backend_with_one_fidelity_refuses_another(pirate_run: Any, backend: str) -> None:
    told = pirate_run(PATROL, "--backend", backend, "--fidelity", "fast")

    assert told.exit_code == 2
    assert f"the backend {backend} cannot be made fast" in told.stderr
    assert "leave out --fidelity" in told.stderr
