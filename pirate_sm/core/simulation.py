"""What a simulated robot is given: friction, defects, twins; and where it truly is."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.simulation import (
    SIMULATORS,
    Defect,
    DefectText,
    Friction,
    Kind,
    RulerSettings,
)
from pirate_sm.core._model.trail import Rows, Stood, Trail, Whereabouts
from pirate_sm.core._model.true_position import InSpace, Truth
from pirate_sm.core._model.twin import Twin
