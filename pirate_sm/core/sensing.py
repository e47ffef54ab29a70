"""What the engine makes of sensors, and how quiet frames pass."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.gliding.glided import Glide, Glided, Step, sensing_after
from pirate_sm.core._engine.gliding.watch import Condition, SameDuty, Watch
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.sensing import environment
from pirate_sm.core._engine.sensing.board_spec import board_name
from pirate_sm.core._engine.sensing.body_spec import WHOLE, BodySpec
from pirate_sm.core._engine.sensing.conversion import ask, forget_stale, measured, observe
from pirate_sm.core._engine.sensing.environment import (
    AGREEING,
    AT_REST,
    COPLANAR_RAD,
    JOINT,
    LEAST_SAMPLES,
    OPEN_RAD,
    SAMPLES,
    SURVEY_EVERY_S,
    TURNED_RAD,
    UPRIGHT,
    Surveyed,
    survey,
)
from pirate_sm.core._engine.sensing.environment_report import NOISE_M, NOISE_RAD
from pirate_sm.core._engine.sensing.joint_around import STEP
from pirate_sm.core._engine.sensing.known_signals import MotorRequest, Sensing, nothing_known
from pirate_sm.core._engine.sensing.part_axes import axis_at, axis_of, meeting, plane_of, wheel_at
from pirate_sm.core._engine.sensing.plausibility import sift, unseen
from pirate_sm.core._engine.sensing.plausibility_spec import WatchedSpec, WatchSpec
from pirate_sm.core._engine.sensing.sensor_memory import Reading
from pirate_sm.core._engine.sensing.traction import with_traction
from pirate_sm.core._engine.sensing.traction_spec import TractionSpec, WheelTraction
from pirate_sm.core._engine.signals import evaluator
from pirate_sm.core._engine.signals.table import Row, signal_table
