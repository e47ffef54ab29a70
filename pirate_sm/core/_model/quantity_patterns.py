"""Regular expressions of quantities for JSON Schemas.

They accept everything that :mod:`pirate_sm.core.units` reads. They cannot compute dimensions: they
accept a unit of three factors, or with an exponent, if it consists of known units.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, Final

from pirate_sm.core import units
from pirate_sm.core.units import UNITS, Dimension

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
        quantity_pattern(dimension, bounds),
        units.expectation(dimension),
        units.unit_of(dimension),
    )


def written_ratio(bounds: Mapping[str, Any]) -> Schema:
    """Return the JSON Schema of text that is a ratio."""
    return _text(f"ratio{_suffix(bounds)}", ratio_pattern(bounds), "a ratio such as '60 %' or 0.6")


def written_quantity() -> Schema:
    """Return the JSON Schema of text that is a number, with a unit or without."""
    return _text("quantity", any_quantity_pattern(), "a quantity such as '120 mm'")


def written_parameter() -> Schema:
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


def number_pattern(bounds: Mapping[str, Any]) -> str:
    """Return the pattern of a number; limits other than 0 depend on the unit and are ignored.

    Args:
        bounds: Limits in SI units by pydantic's names: ``gt``, ``ge``.
    """
    if bounds.get("gt", -1) >= 0:
        return _POSITIVE
    return _NOT_NEGATIVE if bounds.get("ge", -1) >= 0 else _ANY_NUMBER


def quantity_pattern(dimension: Dimension, bounds: Mapping[str, Any]) -> str:
    """Return the pattern of text that is a quantity of this dimension."""
    plain = [name for name, unit in UNITS.items() if unit.dimension == dimension]
    known = [_one_of(plain)] if plain else []
    factor = _factor()
    composed = rf"(?=[^^]*\^|(?:[^*/·]*[*/·]){{2}}){factor}(?:{_TIMES}{factor})*"
    unit = "|".join([*known, *_pairs(dimension), composed])
    # A `1` as the first factor needs a blank before it, or it would be a digit of the number.
    return rf"^\s*{number_pattern(bounds)}(?:\s+|(?!1))(?:{unit})\s*$"


def ratio_pattern(bounds: Mapping[str, Any]) -> str:
    """Return the pattern of a ratio as text, which ends with a percent sign."""
    factor = _factor()
    composed = rf"{factor}(?:{_TIMES}{factor})*{_TIMES}%"
    return rf"^\s*{number_pattern(bounds)}(?:\s+|(?!1))(?:%|{composed})\s*$"


def any_quantity_pattern() -> str:
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
