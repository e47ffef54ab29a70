"""Field types for models: text with a unit in the file, an SI float in the program.

A file must give the unit (`90 deg`, never `90`); Python code passes SI numbers. The two are told
apart by the validation context: the loader validates with `FROM_FILE`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, TypeAlias

from pydantic import (
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    Strict,
    ValidationInfo,
    WithJsonSchema,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from pirate_sm import units
from pirate_sm.units import Dimension, Quantity, QuantityError

FROM_FILE: Final[Mapping[str, Any]] = {"from_file": True}
_PARAMETER = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")


def quantity_fault(message: str, expected: str = "", suggestion: str = "") -> PydanticCustomError:
    """Return an error that pydantic reports under its place, with what a person needs to know."""
    context = {"message": message, "expected": expected, "suggestion": suggestion}
    return PydanticCustomError("quantity", "{message}", context)


def _shown(value: object) -> str:
    """Return a scalar as it stands in the file, anything else by its kind."""
    if isinstance(value, bool):
        return f"'{str(value).lower()}'"
    if isinstance(value, str | int | float):
        return f"'{value}'"
    if value is None:
        return "nothing"
    return "a mapping" if isinstance(value, Mapping) else "a list"


def _finite(value: float, expected: str) -> float:
    if not math.isfinite(value):
        raise quantity_fault(f"expected {expected}, got '{value}'")
    return float(value)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _reader(dimension: Dimension) -> Callable[[Any, ValidationInfo], float]:
    """Return a validator that gives the SI value of a quantity of `dimension`."""
    expected = units.expectation(dimension)

    def read(value: Any, info: ValidationInfo) -> float:
        if isinstance(value, str):
            try:
                return units.read_quantity(value, dimension)
            except QuantityError as error:
                raise quantity_fault(error.message, suggestion=error.suggestion) from None
        if _is_number(value):
            if not (info.context or {}).get("from_file"):
                return _finite(value, expected)
            choices = units.units_of(dimension)
            hint = f"a number with a unit, {choices}" if choices else "a number with a unit"
            raise quantity_fault(f"expected {expected}, got '{value}' without a unit", hint)
        raise quantity_fault(f"expected {expected}, got {_shown(value)}")

    return read


def _read_ratio(value: Any, info: ValidationInfo) -> float:
    expected = "a ratio such as '60 %' or 0.6"
    if _is_number(value):
        return _finite(value, expected)
    if isinstance(value, str) and value.rstrip().endswith("%"):
        return _reader(units.DIMENSIONLESS)(value, info)
    raise quantity_fault(f"expected {expected}, got {_shown(value)}")


def _read_number(value: Any) -> float:
    if _is_number(value):
        return _finite(value, "a bare number")
    raise quantity_fault(f"expected a bare number such as 0.6, got {_shown(value)}")


def _read_any(value: Any) -> Quantity:
    if isinstance(value, Quantity):
        return value
    if _is_number(value):
        expected = "a number or a quantity such as '120 mm'"
        return Quantity(_finite(value, expected), units.DIMENSIONLESS)
    if isinstance(value, str):
        try:
            return units.parse_quantity(value)
        except QuantityError as error:
            raise quantity_fault(error.message, suggestion=error.suggestion) from None
    raise quantity_fault(f"expected a quantity such as '120 mm', got {_shown(value)}")


def _text_schema(dimension: Dimension) -> WithJsonSchema:
    """Return the JSON Schema of a quantity: text that begins with a number."""
    return WithJsonSchema(
        {
            "type": "string",
            "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*[A-Za-z°%]",
            "description": units.describe(dimension),
            "examples": [units.example(dimension)],
        }
    )


_RATIO_SCHEMA = WithJsonSchema(
    {
        "anyOf": [{"type": "number"}, {"type": "string", "pattern": r"%\s*$"}],
        "examples": ["60 %", 0.6],
    }
)
_ANY_SCHEMA = WithJsonSchema({"type": ["number", "string"], "examples": ["120 mm", 0.6]})

Length: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.LENGTH)), _text_schema(units.LENGTH)
]
Angle: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.ANGLE)), _text_schema(units.ANGLE)
]
Duration: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.TIME)), _text_schema(units.TIME)
]
Speed: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.SPEED)), _text_schema(units.SPEED)
]
AngularSpeed: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.ANGULAR_SPEED)), _text_schema(units.ANGULAR_SPEED)
]
Acceleration: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.ACCELERATION)), _text_schema(units.ACCELERATION)
]
AngularAcceleration: TypeAlias = Annotated[
    float,
    BeforeValidator(_reader(units.ANGULAR_ACCELERATION)),
    _text_schema(units.ANGULAR_ACCELERATION),
]
Torque: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.TORQUE)), _text_schema(units.TORQUE)
]
Force: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.FORCE)), _text_schema(units.FORCE)
]
Current: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.CURRENT)), _text_schema(units.CURRENT)
]
Mass: TypeAlias = Annotated[float, BeforeValidator(_reader(units.MASS)), _text_schema(units.MASS)]
Stiffness: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.STIFFNESS)), _text_schema(units.STIFFNESS)
]
ForcePerLength: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.FORCE_PER_LENGTH)), _text_schema(units.FORCE_PER_LENGTH)
]
Frequency: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.FREQUENCY)), _text_schema(units.FREQUENCY)
]
Voltage: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.VOLTAGE)), _text_schema(units.VOLTAGE)
]
Inertia: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.INERTIA)), _text_schema(units.INERTIA)
]
Damping: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.DAMPING)), _text_schema(units.DAMPING)
]
MotorConstant: TypeAlias = Annotated[
    float, BeforeValidator(_reader(units.MOTOR_CONSTANT)), _text_schema(units.MOTOR_CONSTANT)
]
Ratio: TypeAlias = Annotated[float, BeforeValidator(_read_ratio), _RATIO_SCHEMA]
Number: TypeAlias = Annotated[
    float, BeforeValidator(_read_number), WithJsonSchema({"type": "number"})
]
Count: TypeAlias = Annotated[int, Strict(), Field(ge=0)]
# pydantic's own bool takes 'on', 'yes' and 1; in a file those are text and a number.
Flag: TypeAlias = Annotated[bool, Strict()]
AnyQuantity: TypeAlias = Annotated[Quantity, BeforeValidator(_read_any), _ANY_SCHEMA]


@dataclass(frozen=True, slots=True)
class Parameter:
    """Stands where a quantity is wanted for the value that a mission's parameter will have."""

    name: str

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> CoreSchema:
        return core_schema.is_instance_schema(cls)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return {"type": "string", "pattern": f"^{_PARAMETER.pattern}$", "examples": ["$give_up"]}


def _or_parameter(
    read: Callable[[Any, ValidationInfo], Any],
) -> Callable[[Any, ValidationInfo], Any]:
    """Return a validator that takes `$name` for a parameter and leaves the rest to `read`."""

    def read_either(value: Any, info: ValidationInfo) -> Any:
        if isinstance(value, Parameter):
            return value
        if isinstance(value, str) and value.startswith("$"):
            match = _PARAMETER.fullmatch(value)
            if match is None:
                raise quantity_fault(f"expected a parameter such as '$give_up', got '{value}'")
            return Parameter(match[1])
        return read(value, info)

    return read_either


def _read_count(value: Any, info: ValidationInfo) -> int:
    if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
        return value
    raise quantity_fault(f"expected a count such as 3, got {_shown(value)}")


_PARAMETER_SCHEMA = WithJsonSchema({"type": ["string", "number"], "examples": ["10 s", "$give_up"]})

DurationOrParameter: TypeAlias = Annotated[
    float | Parameter, BeforeValidator(_or_parameter(_reader(units.TIME))), _PARAMETER_SCHEMA
]
LengthOrParameter: TypeAlias = Annotated[
    float | Parameter, BeforeValidator(_or_parameter(_reader(units.LENGTH))), _PARAMETER_SCHEMA
]
AngleOrParameter: TypeAlias = Annotated[
    float | Parameter, BeforeValidator(_or_parameter(_reader(units.ANGLE))), _PARAMETER_SCHEMA
]
RatioOrParameter: TypeAlias = Annotated[
    float | Parameter, BeforeValidator(_or_parameter(_read_ratio)), _PARAMETER_SCHEMA
]
CountOrParameter: TypeAlias = Annotated[
    int | Parameter, BeforeValidator(_or_parameter(_read_count)), _PARAMETER_SCHEMA
]
