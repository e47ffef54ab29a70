"""The description of a robot: boards, signals, body, motors, commands."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

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
from pirate_sm.core._model.robot.profile import (
    Board,
    Channel,
    Command,
    DetectorPoint,
    LinkSettings,
    PassedBy,
    Profile,
    SafetyRule,
    Slot,
    Travel,
)
from pirate_sm.core._model.robot.signals import Advice, Serial, SetpointTopic, StateTopic
