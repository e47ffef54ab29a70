"""What the engine makes of sensors, and how quiet frames pass."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.gliding.quiet_frames import (
    Condition,
    Glide,
    Glided,
    SameDuty,
    Step,
    Watch,
    sensing_after,
)
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.sensing import environment, evaluator, surveyor
from pirate_sm.core._engine.sensing.board_spec import (
    TractionSpec,
    WatchedSpec,
    WatchSpec,
    WheelTraction,
    board_name,
)
from pirate_sm.core._engine.sensing.body_spec import (
    WHOLE,
    BodySpec,
    axis_at,
    axis_of,
    meeting,
    plane_of,
    wheel_at,
)
from pirate_sm.core._engine.sensing.environment import (
    JOINT,
    Surveyed,
    survey,
)
from pirate_sm.core._engine.sensing.known_signals import MotorRequest, Sensing, nothing_known
from pirate_sm.core._engine.sensing.plausibility import Reading, sift, unseen
from pirate_sm.core._engine.sensing.signal_table import (
    Row,
    ask,
    forget_stale,
    measured,
    observe,
    signal_table,
)
from pirate_sm.core._engine.sensing.traction import with_traction
