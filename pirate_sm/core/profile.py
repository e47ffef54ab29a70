"""The description of a robot: boards, signals, body, motors, commands."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model import body, criteria, derived
from pirate_sm.core._model.actuation import (
    Duty,
    HeldTorque,
    Level,
    PostureCase,
    Share,
    Speed,
    Stage,
    Target,
)
from pirate_sm.core._model.base import DEFINED, LONGEST_NAME, Format, Frozen, Name
from pirate_sm.core._model.body import Body, Link, Wheel
from pirate_sm.core._model.calibration import Calibration
from pirate_sm.core._model.control import Control, Grip
from pirate_sm.core._model.criteria import Load, Stalled, Turning
from pirate_sm.core._model.motor import Motor
from pirate_sm.core._model.profile import (
    Board,
    Channel,
    Command,
    DetectorPoint,
    LinkSettings,
    Profile,
    Slot,
)
from pirate_sm.core._model.safety import SafetyRule
from pirate_sm.core._model.serial_link import Advice, Serial, SetpointTopic, StateTopic
from pirate_sm.core._model.travel import PassedBy, Travel
