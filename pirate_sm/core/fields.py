"""What the fields of files are made of: names, quantities, other ways to write a value."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._model.base import (
    DEFINED,
    LONGEST_NAME,
    AlsoWritten,
    Date,
    FaultCode,
    Format,
    Frozen,
    Name,
    by_key,
)
from pirate_sm.core._model.quantities import (
    FROM_FILE,
    QUANTITY,
    Angle,
    AngularSpeed,
    AnyQuantity,
    Count,
    Damping,
    Duration,
    Flag,
    Frequency,
    Inertia,
    Length,
    Number,
    Parameter,
    Pixels,
    PositiveLength,
    Ratio,
    Speed,
    SpringRate,
    Torque,
    VelocityGain,
    kind_fault,
    quantity_fault,
    range_fault,
)
