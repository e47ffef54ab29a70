"""Resume a mission after a crash."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._engine.resuming.hypotheses import hypotheses
from pirate_sm.core._engine.resuming.reconciling import (
    Reconciled,
    VerdictTable,
    adoptable,
    reconcile,
)
from pirate_sm.core._engine.resuming.resumption import (
    AS_DECLARED,
    FAILURE,
    Beginning,
    Refused,
    Resumption,
    resumption,
    unknowns,
)
from pirate_sm.core._engine.unwatched import DarkWay
