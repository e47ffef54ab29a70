"""Parameters of a mission, which are constant during a run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, TypeAlias, get_args

from pydantic import Strict

from pirate_sm.core._model.base import Frozen
from pirate_sm.core.units import (
    ANGLE,
    ANGULAR_SPEED,
    CURRENT,
    DIMENSIONLESS,
    FORCE,
    LENGTH,
    SPEED,
    TIME,
    TORQUE,
    Dimension,
    QuantityError,
    parse_quantity,
)

ParameterType: TypeAlias = Literal[
    "duration", "length", "angle", "speed", "angular_speed", "torque", "force", "current",
    "ratio", "count", "number",
]  # fmt: skip
DIMENSIONS: Mapping[str, Dimension] = {
    "duration": TIME, "length": LENGTH, "angle": ANGLE, "speed": SPEED,
    "angular_speed": ANGULAR_SPEED, "torque": TORQUE, "force": FORCE, "current": CURRENT,
    "ratio": DIMENSIONLESS, "count": DIMENSIONLESS, "number": DIMENSIONLESS,
}  # fmt: skip
# Strict, because `true` would count as 1.
ParameterValue: TypeAlias = (
    Annotated[str, Strict()] | Annotated[int, Strict()] | Annotated[float, Strict()]
)


class ParameterDefinition(Frozen):
    """A parameter of a mission; without a default it must be given.

    Attributes:
        type: The kind of value, which determines the valid units.
        default: The value if none is given; without a default it must be given.
        min: The smallest valid value.
        max: The largest valid value.
        description: One-line description.
    """

    type: ParameterType
    default: ParameterValue | None = None
    min: ParameterValue | None = None
    max: ParameterValue | None = None
    description: str = ""


def type_of(value: object) -> ParameterType | None:
    """Return the type of parameter that has such a value; None without a unit."""
    try:
        dimension = parse_quantity(str(value)).dimension
    except QuantityError:
        return None
    known: tuple[ParameterType, ...] = get_args(ParameterType)
    sure = (each for each in known if DIMENSIONS[each] == dimension != DIMENSIONLESS)
    return next(sure, None)
