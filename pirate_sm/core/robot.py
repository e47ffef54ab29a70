"""The robot as the engine commands it: its specification, its state, its commands."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.control.grip import torque_nm
from pirate_sm.core._engine.robot import confirmation, robot_state
from pirate_sm.core._engine.robot.chart_table import ChartTable, Configuration
from pirate_sm.core._engine.robot.command_needs import Need, RegionChange, changes, needs
from pirate_sm.core._engine.robot.command_outcome import lets_all_go, marks_after, refusal
from pirate_sm.core._engine.robot.command_spec import SlotSpec, StageSpec, Write
from pirate_sm.core._engine.robot.confirmation import declared_in
from pirate_sm.core._engine.robot.confirmation_spec import (
    AnglesSpec,
    DrivenSpec,
    HeldSpec,
    ImpliedSpec,
    SeenSpec,
    StandingSpec,
)
from pirate_sm.core._engine.robot.criteria import (
    AcceptedSpec,
    AlignedSpec,
    BelowSpec,
    CriterionSpec,
    ReachedSpec,
    StalledSpec,
    StoppedSpec,
    TurningSpec,
)
from pirate_sm.core._engine.robot.planning import Plan, RulePlaces, plans
from pirate_sm.core._engine.robot.robot_spec import USUAL, FaultSpec, RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    STOPPED,
    Flight,
    Mark,
    RobotState,
    at_rest_in,
    confirmed_parts,
    known_values,
    obeyed,
    state_change,
    states_of,
)
from pirate_sm.core._engine.robot.sensor_verdict import verdict
from pirate_sm.core._engine.safety import rules
from pirate_sm.core._engine.safety.faults import no_faults
