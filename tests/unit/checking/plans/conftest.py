"""A shipped mission, and the robot standing somewhere in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.loading import load_mission
from pirate_sm.core.robot import at_rest_in

ROOT = Path(__file__).resolve().parents[4]


@pytest.fixture(scope="module")
def bend():
    return load_mission(ROOT / "sequences" / "mitre_bend.yaml")


def standing(loaded, *states):
    return at_rest_in(loaded.robot, loaded.robot.table.index_of(states))
