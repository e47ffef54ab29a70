"""Field types of models for quantities: text with a unit in files, SI floats in the program.

A file must give the unit (`90 deg`, never `90`); Python code passes SI numbers. The validation
context distinguishes the two: the loader validates with `FROM_FILE`. The regular expressions for
JSON Schemas accept everything that :mod:`pirate_sm.core.units` reads. They cannot compute
dimensions: they accept a unit of three factors, or with an exponent, if it consists of known units.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
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

from pirate_sm.core import units
from pirate_sm.core.spelling import one_of
from pirate_sm.core.units import UNITS, Dimension, Quantity, QuantityError

Schema = dict[str, Any]

QUANTITY: Final = "x-quantity"
"""Key for shared schemas of quantities: holds the schema's name and the SI unit of a default."""

_DIGITS: Final = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_EXPONENT: Final = r"(?:[eE][+-]?[0-9]+)?"
_ANY_NUMBER: Final = rf"[+-]?{_DIGITS}{_EXPONENT}"
_NOT_NEGATIVE: Final = rf"(?:\+?{_DIGITS}|-(?:0+(?:\.0*)?|\.0+)){_EXPONENT}"
_POSITIVE: Final = rf"\+?(?=[0-9.]*[1-9]){_DIGITS}{_EXPONENT}"

_TIMES: Final = r"\s*[*/·]\s*"


def written(dimension: Dimension, bounds: Mapping[str, Any]) -> Schema:
    """Return the JSON Schema of text that is a quantity of this dimension.

    Args:
        dimension: The dimension.
        bounds: Limits in SI units by pydantic's names: ``gt``, ``ge``, ``lt``, ``le``.
    """
    name = units.describe(dimension).partition(" ")[2].replace(" ", "_")
    return _text(
        name + _suffix(bounds),
        _quantity_pattern(dimension, bounds),
        units.expectation(dimension),
        units.unit_of(dimension),
    )


def written_ratio(bounds: Mapping[str, Any]) -> Schema:
    """Return the JSON Schema of text that is a ratio."""
    return _text(f"ratio{_suffix(bounds)}", _ratio_pattern(bounds), "a ratio such as '60 %' or 0.6")


def _written_quantity() -> Schema:
    """Return the JSON Schema of text that is a number, with a unit or without."""
    return _text("quantity", _any_quantity_pattern(), "a quantity such as '120 mm'")


def _written_parameter() -> Schema:
    """Return the JSON Schema of text that refers to a mission's parameter."""
    return _text("parameter", r"^\$[A-Za-z_][A-Za-z0-9_]*$", "a parameter such as '$give_up'")


def _text(name: str, pattern: str, expected: str, unit: str = "") -> Schema:
    return {
        "type": "string",
        "pattern": pattern,
        "patternErrorMessage": f"expected {expected}",
        QUANTITY: {"name": name, "unit": unit},
    }


def _suffix(bounds: Mapping[str, Any]) -> str:
    if bounds.get("gt", -1) >= 0:
        return "_above_0"
    return "_from_0" if bounds.get("ge", -1) >= 0 else ""


def _number_pattern(bounds: Mapping[str, Any]) -> str:
    """Return the pattern of a number; limits other than 0 depend on the unit and are ignored.

    Args:
        bounds: Limits in SI units by pydantic's names: ``gt``, ``ge``.
    """
    if bounds.get("gt", -1) >= 0:
        return _POSITIVE
    return _NOT_NEGATIVE if bounds.get("ge", -1) >= 0 else _ANY_NUMBER


def _quantity_pattern(dimension: Dimension, bounds: Mapping[str, Any]) -> str:
    """Return the pattern of text that is a quantity of this dimension."""
    plain = [name for name, unit in UNITS.items() if unit.dimension == dimension]
    known = [_one_of(plain)] if plain else []
    factor = _factor()
    composed = rf"(?=[^^]*\^|(?:[^*/·]*[*/·]){{2}}){factor}(?:{_TIMES}{factor})*"
    unit = "|".join([*known, *_pairs(dimension), composed])
    # A `1` as the first factor needs a blank before it, or it would be a digit of the number.
    return rf"^\s*{_number_pattern(bounds)}(?:\s+|(?!1))(?:{unit})\s*$"


def _ratio_pattern(bounds: Mapping[str, Any]) -> str:
    """Return the pattern of a ratio as text, which ends with a percent sign."""
    factor = _factor()
    composed = rf"{factor}(?:{_TIMES}{factor})*{_TIMES}%"
    return rf"^\s*{_number_pattern(bounds)}(?:\s+|(?!1))(?:%|{composed})\s*$"


def _any_quantity_pattern() -> str:
    """Return the pattern of a number with any known unit or without a unit."""
    factor = _factor()
    return rf"^\s*{_ANY_NUMBER}(?:(?:\s+|(?!1)){factor}(?:{_TIMES}{factor})*)?\s*$"


def _factor() -> str:
    return rf"{_one_of(UNITS)}(?:\^-?[0-9])?"


@cache
def _pairs(dimension: Dimension) -> list[str]:
    """Return a pattern for each two dimensions whose product or quotient is this one."""
    names = _names_by_dimension()
    pairs = [
        (first, sign, second)
        for first in names
        for second in names
        for sign, result in (("[*·]", first * second), ("/", first / second))
        if result == dimension
    ]
    return [
        rf"{_one_of(names[first])}\s*{sign}\s*{_one_of(names[second])}"
        for first, sign, second in pairs
    ]


@cache
def _names_by_dimension() -> dict[Dimension, list[str]]:
    names: dict[Dimension, list[str]] = {}
    for name, unit in UNITS.items():
        names.setdefault(unit.dimension, []).append(name)
    return names


def _one_of(names: Iterable[str]) -> str:
    return f"(?:{'|'.join(re.escape(name) for name in names)})"


FROM_FILE: Final[Mapping[str, Any]] = {"from_file": True}
_PARAMETER = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*)")
_ANY_UNIT = f"a number with a unit, {one_of(units.UNITS, len(units.UNITS))}"
_PIXELS = re.compile(r"(\d{1,5}(?:\.\d{1,9})?) ?px")


INCHES: Final = {
    **dict.fromkeys(("in", "inch", "inches"), 1),
    **dict.fromkeys(("ft", "foot", "feet"), 12),
}
"""Units of length that are not read, in inches of 25.4 mm."""

_DECIMAL_COMMA: Final = re.compile(r"([+-]?\d+),(\d{1,2}|\d{4,})(?!\d)")
"""Three digits after a comma may be thousands."""


def read_quantity(text: str, dimension: Dimension) -> float:
    """Return the SI value of a quantity; suggest one for inches, `μm` and a decimal comma.

    Raises:
        QuantityError: As of :func:`units.read_quantity`.
    """
    try:
        return units.read_quantity(text, dimension)
    except QuantityError as error:
        suggestion = error.suggestion or _translated(text, dimension)
        raise QuantityError(error.message, suggestion) from None


def _translated(text: str, dimension: Dimension) -> str:
    """Return a quantity that is written as elsewhere in our form; empty if it is none."""
    ours = _DECIMAL_COMMA.sub(r"\1.\2", text.strip().replace("μ", "u"))  # the Greek letter
    number, _, unit = ours.partition(" ")
    try:
        if inches := INCHES.get(unit.lower()):
            ours = f"{float(number) * inches * 25.4:g} mm"
        units.read_quantity(ours, dimension)
    except ValueError:
        return ""
    return ours


def quantity_fault(message: str, expected: str = "", suggestion: str = "") -> PydanticCustomError:
    """Return an error about an invalid quantity, with the expected input and a suggestion."""
    context = {"message": message, "expected": expected, "suggestion": suggestion}
    return PydanticCustomError("quantity", "{message}", context)


def key_fault(message: str, *keys: str, expected: str = "") -> PydanticCustomError:
    """Return an error about keys of a mapping; it is shown at the last of them in the file."""
    context = {"message": message, "expected": expected, "keys": " ".join(keys)}
    return PydanticCustomError("key", "{message}", context)


def kind_fault(message: str) -> PydanticCustomError:
    """Return an error about a value that is of another kind than expected."""
    return PydanticCustomError("kind", "{message}", {"message": message})


def range_fault(message: str) -> PydanticCustomError:
    """Return an error about a value of the right form that exceeds its limits."""
    return PydanticCustomError("range", "{message}", {"message": message})


def _shown(value: object) -> str:
    """Return a scalar as in the file, and the kind of any other value."""
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
    """Return a validator that returns the SI value of a quantity of `dimension`."""
    expected = units.expectation(dimension)
    hint = f"a number with a unit, {units.units_of(dimension)}"

    def read(value: Any, info: ValidationInfo) -> float:
        if isinstance(value, str):
            try:
                return read_quantity(value, dimension)
            except QuantityError as error:
                raise quantity_fault(error.message, hint, error.suggestion) from None
        if _is_number(value):
            if not (info.context or {}).get("from_file"):
                return _finite(value, expected)
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


def _read_pixels(value: Any, info: ValidationInfo) -> float:
    if _is_number(value) and not (info.context or {}).get("from_file"):
        return _finite(value, "a number of pixels")
    match = _PIXELS.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        raise quantity_fault(f"expected a number of pixels such as '5 px', got {_shown(value)}")
    return float(match[1])


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
            raise quantity_fault(error.message, _ANY_UNIT, error.suggestion) from None
    raise quantity_fault(f"expected a quantity such as '120 mm', got {_shown(value)}")


@dataclass(frozen=True, slots=True)
class _Written:
    """JSON Schema annotation for the text form of a quantity of a dimension."""

    dimension: Dimension

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        bounds = _bounds(handler(schema))
        expected = f"{units.expectation(self.dimension)}{_limits(bounds, self.dimension)}."
        return {
            **written(self.dimension, bounds),
            "description": expected[0].upper() + expected[1:],
            "examples": [units.example(self.dimension)],
        }


class _WrittenRatio:
    """JSON Schema annotation for the text form of a ratio."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        bounds = _bounds(handler(schema))
        limits = {_JSON_BOUNDS[name]: limit for name, limit in bounds.items()}
        return {
            "anyOf": [{"type": "number", **limits}, written_ratio(bounds)],
            "description": f"A ratio such as 60 % or 0.6{_limits(bounds, units.DIMENSIONLESS)}.",
            "examples": ["60 %", 0.6],
        }


_JSON_BOUNDS: Final = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}
_LIMITS: Final = {"gt": "more than", "ge": "at least", "lt": "less than", "le": "at most"}


def _bounds(schema: JsonSchemaValue) -> dict[str, float]:
    """Return the limits in SI units, by pydantic's names."""
    return {
        name: schema[key]
        for name, json_name in _JSON_BOUNDS.items()
        for key in (name, json_name)
        if key in schema
    }


def _limits(bounds: Mapping[str, float], dimension: Dimension) -> str:
    """Return the limits as text, each after a comma."""
    unit = units.unit_of(dimension)
    shown = {name: f"{limit:g} {unit}" if limit else "0" for name, limit in bounds.items()}
    return "".join(f", {_LIMITS[name]} {limit.strip()}" for name, limit in shown.items())


def _of(dimension: Dimension) -> tuple[BeforeValidator, _Written]:
    """Return how a quantity of a dimension is read, and what a JSON Schema says of it."""
    return BeforeValidator(_reader(dimension)), _Written(dimension)


_ANY_SCHEMA = WithJsonSchema(
    {
        "anyOf": [{"type": "number"}, _written_quantity()],
        "description": "A number, or a quantity such as '120 mm'.",
        "examples": ["120 mm", 0.6],
    }
)

Pixels: TypeAlias = Annotated[
    float,
    BeforeValidator(_read_pixels),
    WithJsonSchema(
        {
            "type": "string",
            "pattern": f"^{_PIXELS.pattern}$",
            "description": "A number of pixels such as 5 px.",
            "examples": ["5 px"],
        }
    ),
]
Length: TypeAlias = Annotated[float, *_of(units.LENGTH)]
PositiveLength: TypeAlias = Annotated[Length, Field(gt=0)]
Angle: TypeAlias = Annotated[float, *_of(units.ANGLE)]
Duration: TypeAlias = Annotated[float, *_of(units.TIME)]
PositiveDuration: TypeAlias = Annotated[Duration, Field(gt=0)]
Frequency: TypeAlias = Annotated[float, *_of(units.FREQUENCY)]
Inertia: TypeAlias = Annotated[float, *_of(units.INERTIA)]
Speed: TypeAlias = Annotated[float, *_of(units.SPEED)]
AngularSpeed: TypeAlias = Annotated[float, *_of(units.ANGULAR_SPEED)]
Acceleration: TypeAlias = Annotated[float, *_of(units.ACCELERATION)]
Torque: TypeAlias = Annotated[float, *_of(units.TORQUE)]
Current: TypeAlias = Annotated[float, *_of(units.CURRENT)]
Mass: TypeAlias = Annotated[float, *_of(units.MASS)]
Stiffness: TypeAlias = Annotated[float, *_of(units.STIFFNESS)]
SpringRate: TypeAlias = Annotated[float, *_of(units.FORCE_PER_LENGTH)]
Damping: TypeAlias = Annotated[float, *_of(units.DAMPING)]
VelocityGain: TypeAlias = Annotated[float, *_of(units.VELOCITY_GAIN)]
Ratio: TypeAlias = Annotated[float, BeforeValidator(_read_ratio), _WrittenRatio()]
Number: TypeAlias = Annotated[
    float, BeforeValidator(_read_number), WithJsonSchema({"type": "number"})
]
Count: TypeAlias = Annotated[int, Strict(), Field(ge=0)]
# pydantic's bool accepts 'on', 'yes' and 1, which are text and a number in files.
Flag: TypeAlias = Annotated[bool, Strict()]
AnyQuantity: TypeAlias = Annotated[Quantity, BeforeValidator(_read_any), _ANY_SCHEMA]


@dataclass(frozen=True, slots=True)
class Parameter:
    """A reference to a mission's parameter instead of a quantity."""

    name: str

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> CoreSchema:
        return core_schema.is_instance_schema(cls)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        return _written_parameter()


def _or_parameter(
    read: Callable[[Any, ValidationInfo], Any],
) -> Callable[[Any, ValidationInfo], Any]:
    """Return a validator that reads `$name` as a parameter and other values with `read`."""

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
    if isinstance(value, int) and not isinstance(value, bool):
        raise range_fault(f"expected a count of at least 0, got {value}")
    raise quantity_fault(f"expected a count such as 3, got {_shown(value)}")


class _OrParameter:
    """JSON Schema annotation for `$name` instead of a quantity or a count."""

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        value, parameter = handler(schema)["anyOf"]
        said = value.pop("description").removesuffix(".")
        about = f"{said}, or a parameter such as $give_up."
        examples = [*value.pop("examples"), "$give_up"]
        return {"anyOf": [value, parameter], "description": about, "examples": examples}


_COUNT_SCHEMA = WithJsonSchema(
    {"type": "integer", "minimum": 0, "description": "A count such as 3.", "examples": [3]}
)

DurationOrParameter: TypeAlias = Annotated[
    Annotated[float, _Written(units.TIME)] | Parameter,
    BeforeValidator(_or_parameter(_reader(units.TIME))),
    _OrParameter(),
]
CountOrParameter: TypeAlias = Annotated[
    Annotated[int, _COUNT_SCHEMA] | Parameter,
    BeforeValidator(_or_parameter(_read_count)),
    _OrParameter(),
]
