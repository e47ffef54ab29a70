from __future__ import annotations

from pathlib import Path

import pytest

import pirate_sm

ROOT = Path(__file__).resolve().parents[3]
NEWT = ROOT / "tests" / "robots" / "newt"
PATROL = NEWT / "patrol.yaml"


@pytest.fixture(scope="session")
def patrol() -> pirate_sm.LoadedMission:
    return pirate_sm.load(PATROL)


@pytest.fixture
def faulty(tmp_path: Path) -> Path:
    """A mission that lets go of the pipe, which the check refuses."""
    file = tmp_path / "stuck.yaml"
    file.write_text(
        "format: 1\nmission: stuck\nrobot: pirate_ii\npipe: straight_113\nstart: go\n"
        "phases:\n  go: {do: [ClampFront, ClampRear, RelaxFront, RelaxRear], go: there}\n"
        "ends:\n  there: {succeed: There}\n"
    )
    return file


@pytest.fixture(scope="session")
def patrolled(patrol: pirate_sm.LoadedMission) -> pirate_sm.Run:
    return pirate_sm.run(patrol, seed=2)
