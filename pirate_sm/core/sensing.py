"""What the engine makes of sensors, and how quiet frames pass."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.gliding.lookout import Lookout
from pirate_sm.core._engine.gliding.quiet_frames import (
    Condition,
    Glide,
    Glided,
    SameDuty,
    Step,
    Watch,
)
from pirate_sm.core._engine.recorded_robot import RobotListener, RobotLook
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.sensing import environment, evaluator, surveyor
from pirate_sm.core._engine.sensing.board_spec import board_name
from pirate_sm.core._engine.sensing.body_spec import WHOLE, BodySpec
from pirate_sm.core._engine.sensing.environment import (
    JOINT,
    Surveyed,
)
from pirate_sm.core._engine.sensing.frame_judge import FrameJudge
from pirate_sm.core._engine.sensing.known_signals import MotorRequest, Sensing, nothing_known
from pirate_sm.core._engine.sensing.signal_table import Row, ask, signal_table
from pirate_sm.core._engine.sensing.traction import with_traction
