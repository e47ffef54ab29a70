"""What the engine does: its effects, and how views show them."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.effects import (
    EFFECT_TABLES,
    Ask,
    CommandStatus,
    Detected,
    Effect,
    Ended,
    Fault,
    LaneMark,
    LaneSpan,
    Level,
    Log,
    MarkKind,
    PhaseChange,
    Setpoints,
    SpanKind,
    StateChange,
    TriggerFired,
    WaitArmed,
    WakeAt,
    display_of,
    with_reason,
)
from pirate_sm.core._model.unmet import Unmet
