"""Missions as they are written: phases, steps, triggers."""

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
from pirate_sm.core._model.triggers import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger
