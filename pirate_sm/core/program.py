"""Missions as the engine runs them: programs and their instructions."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.mission import program
from pirate_sm.core._engine.mission.interpreter import ROUND_AND_ROUND
from pirate_sm.core._engine.mission.operator import why_not_command
from pirate_sm.core._engine.mission.pausing import why_not_on, why_not_to
from pirate_sm.core._engine.mission.program import (
    HERE,
    STOP,
    Branch,
    Do,
    HandlerSpec,
    Program,
    Question,
    Raise,
    Require,
    Say,
    SwitchControl,
    TriggerSpec,
    Wait,
)
from pirate_sm.core._engine.mission.scripted_signals import awaits_torques
from pirate_sm.core._engine.mission.successors import failures, reached, successes, successors
