"""Missions as the engine runs them: programs and their instructions."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.inputs import awaits_torques
from pirate_sm.core._engine.mission.interpreter import ROUND_AND_ROUND
from pirate_sm.core._engine.mission.program import (
    HERE,
    STOP,
    Branch,
    BranchKey,
    Do,
    Enter,
    Finish,
    HandlerSpec,
    Instruction,
    Program,
    Question,
    Raise,
    Require,
    Say,
    SwitchControl,
    TriggerSpec,
    Wait,
)
