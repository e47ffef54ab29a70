"""The kinds of quantities that files hold, as types of fields."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model import quantities
from pirate_sm.core._model.quantities import (
    FROM_FILE,
    QUANTITY,
    Angle,
    Count,
    Duration,
    Length,
    Number,
    Parameter,
    Speed,
)
