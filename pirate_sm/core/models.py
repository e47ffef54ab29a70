"""The models of files: missions, pipes, robots and their twins, as they are written."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.mission import (
    CONTINUE,
    CONTROL_WITHIN_S,
    FAIL,
    AskStep,
    CallStep,
    ChooseStep,
    CommandStep,
    ControlStep,
    End,
    FaultHandler,
    LogStep,
    Mission,
    Phase,
    RepeatStep,
    Step,
    WaitStep,
    every_step,
)
from pirate_sm.core._model.pipe import Blockage, FrictionStretch, Pipe, PipeFile, Turns
from pirate_sm.core._model.pipe_runs import PipeRun, Straight
from pirate_sm.core._model.robot import done_criteria, signals
from pirate_sm.core._model.robot.actuation import (
    Control,
    Duty,
    Grip,
    HeldTorque,
    Level,
    PostureCase,
    Share,
    Speed,
    Stage,
    Target,
)
from pirate_sm.core._model.robot.body import Body, Link, Motor, Wheel
from pirate_sm.core._model.robot.defects import Defect, DefectText, Kind
from pirate_sm.core._model.robot.profile import (
    Board,
    Channel,
    Command,
    DetectorDefinition,
    LinkSettings,
    PassedBy,
    Profile,
    SafetyRule,
    Slot,
    Travel,
)
from pirate_sm.core._model.robot.signals import Advice, Serial, SetpointTopic, StateTopic
from pirate_sm.core._model.robot.simulation import (
    PARTS_OF_A_TWIN,
    SIMULATORS,
    Friction,
    LineFaults,
    RulerSettings,
    Twin,
)
from pirate_sm.core._model.triggers import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger
