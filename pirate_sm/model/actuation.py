"""What a state writes to the slots: duty cycles, angles, or nothing new."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import BeforeValidator, PlainSerializer, WithJsonSchema

from pirate_sm.model.base import Name
from pirate_sm.model.patterns import written, written_ratio
from pirate_sm.units import ANGLE, DIMENSIONLESS, QuantityError, parse_quantity


class Duty(NamedTuple):
    """A duty cycle, -1..1."""

    value: float


class Target(NamedTuple):
    """An angle in rad to come to."""

    angle_rad: float


KEEP: Literal["keep"] = "keep"

Setpoint: TypeAlias = Duty | Target | Literal["keep"]


def _read(value: Any) -> Any:
    if isinstance(value, (Duty, Target)) or value == KEEP:
        return value
    if isinstance(value, str):
        try:
            quantity = parse_quantity(value)
        except QuantityError as error:
            raise ValueError(str(error)) from None
        if quantity.dimension == ANGLE:
            return Target(quantity.value)
        if quantity.dimension == DIMENSIONLESS and value.rstrip().endswith("%"):
            if abs(quantity.value) > 1:
                raise ValueError(f"a duty cycle lies between -100 % and 100 %, got '{value}'")
            return Duty(quantity.value)
    raise ValueError(
        f"expected a duty cycle such as '60 %', an angle such as '-45 deg', or keep, got '{value}'"
    )


def _write(value: Setpoint) -> str:
    if isinstance(value, Duty):
        return f"{value.value * 100:g} %"
    return f"{value.angle_rad} rad" if isinstance(value, Target) else value


SlotSetpoint = Annotated[
    Any,
    BeforeValidator(_read),
    PlainSerializer(_write),
    WithJsonSchema(
        {
            "anyOf": [
                {"const": KEEP, "description": "The last accepted value stays."},
                {
                    **written_ratio({}),
                    "description": "A duty cycle such as '60 %', of the full voltage.",
                },
                {
                    **written(ANGLE, {}),
                    "description": "An angle such as '-45 deg' to come to.",
                },
            ],
            "description": "A duty cycle such as '60 %', an angle such as '-45 deg', or keep.",
            "examples": ["60 %", "-45 deg", KEEP],
        }
    ),
]

Stage: TypeAlias = dict[Name, SlotSetpoint]
