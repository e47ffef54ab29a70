"""The engine and its state."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.engine import Engine
from pirate_sm.core._engine.moment import has_come
from pirate_sm.core._engine.robot.evidence import SHOWN, Evidence
from pirate_sm.core._engine.state import EngineState
