"""What the engine does: its effects, and how views show them."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.effect_display import (
    EFFECT_TABLES,
    LaneMark,
    LaneSpan,
    Level,
    MarkKind,
    SpanKind,
    with_reason,
)
from pirate_sm.core._model.effects import (
    Ask,
    CommandStatus,
    Detected,
    Effect,
    Ended,
    Environment,
    Fault,
    Log,
    PhaseChange,
    Setpoints,
    StateChange,
    TriggerFired,
    WaitArmed,
    WakeAt,
    display_of,
)
from pirate_sm.core._model.unmet import Unmet
