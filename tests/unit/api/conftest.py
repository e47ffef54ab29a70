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


@pytest.fixture(scope="session")
def patrolled(patrol: pirate_sm.LoadedMission) -> pirate_sm.Run:
    return pirate_sm.run(patrol, seed=2)
