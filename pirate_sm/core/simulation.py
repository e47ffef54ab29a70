"""What a simulated robot is given: friction, defects, twins; and where it truly is."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.robot.simulation import (
    SIMULATORS,
    Defect,
    DefectText,
    Friction,
    Kind,
    LineFaults,
    RulerSettings,
    Twin,
)
from pirate_sm.core._model.whereabouts import InSpace, Rows, Stood, Trail, Truth, Whereabouts
