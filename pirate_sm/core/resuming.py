"""Resume a mission after a crash."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.resuming.adopting import adoptable, shown_instead
from pirate_sm.core._engine.resuming.dark_way import DarkWay
from pirate_sm.core._engine.resuming.entry import FAILURE, Refused
from pirate_sm.core._engine.resuming.hypotheses import Hypothesis, hypotheses
from pirate_sm.core._engine.resuming.reconciling import (
    Reconciled,
    VerdictTable,
    reconcile,
    verdicts,
)
from pirate_sm.core._engine.resuming.resumption import (
    AS_DECLARED,
    Beginning,
    Resumption,
    resumption,
)
from pirate_sm.core._engine.resuming.unknowns import position_read, unknown_position, unknowns
