"""Parameters of a mission: constants of a run."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Strict

from pirate_sm.model.base import Frozen

ParameterType: TypeAlias = Literal[
    "duration", "length", "angle", "speed", "angular_speed", "torque", "force", "current",
    "ratio", "count", "number",
]  # fmt: skip
# Strict: else `true` would be the count 1.
ParameterValue: TypeAlias = (
    Annotated[str, Strict()] | Annotated[int, Strict()] | Annotated[float, Strict()]
)


class ParameterDefinition(Frozen):
    """A constant of a run; without a default it must be given.

    Attributes:
        type: What the value is, and so which units fit.
        default: The value when none is given; without a default it must be given.
        min: The least value that may be given.
        max: The largest value that may be given.
        description: One line for people.
    """

    type: ParameterType
    default: ParameterValue | None = None
    min: ParameterValue | None = None
    max: ParameterValue | None = None
    description: str = ""
