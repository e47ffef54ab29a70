"""Columns that compiled code knows as numbers."""

from __future__ import annotations

from pirate_sm.simulation.gliding import columns
from pirate_sm.simulation.physics import PER_WHEEL


def test_the_block_of_pressing_forces_is_that_of_every_physics() -> None:
    assert PER_WHEEL[columns.PRESS] == "press"
