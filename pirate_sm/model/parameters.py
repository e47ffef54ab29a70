"""Parameters of a mission, which are constant during a run."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Strict

from pirate_sm.model.base import Frozen

ParameterType: TypeAlias = Literal[
    "duration", "length", "angle", "speed", "angular_speed", "torque", "force", "current",
    "ratio", "count", "number",
]  # fmt: skip
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
