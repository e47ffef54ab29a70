"""The robot as the engine commands it: its specification, its state, its commands."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine import safety
from pirate_sm.core._engine.mission.planning import Plan, RulePlaces, plans
from pirate_sm.core._engine.robot import declared_states, duty_cycles
from pirate_sm.core._engine.robot.actuation_spec import SlotSpec, StageSpec, Write
from pirate_sm.core._engine.robot.command_outcome import lets_all_go, marks_after, refusal
from pirate_sm.core._engine.robot.criteria import (
    CriterionSpec,
    HeldSpec,
    Need,
    SeenSpec,
    TorqueBorne,
    WheelTurning,
    needs_of_signals,
)
from pirate_sm.core._engine.robot.evidence import verdict
from pirate_sm.core._engine.robot.loops import torque_nm
from pirate_sm.core._engine.robot.robot_spec import (
    USUAL,
    ChartTable,
    Configuration,
    FaultSpec,
    RobotSpec,
)
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    STOPPED,
    Mark,
    RobotState,
    at_rest_in,
    confirmed_parts,
    known_values,
    obeyed,
    state_change,
    states_of,
)
