"""Conversion of quantities between text (`120 mm`, `28 deg`) and SI floats.

A dimension is a vector of exponents over the SI base quantities in use here. Angle is a base
dimension although SI treats it as dimensionless. This lets the program reject `28 deg` where a
ratio is wanted, and distinguish a stiffness in Nm/rad from a torque in Nm.
"""

from __future__ import annotations

import math
import re
from dataclasses import astuple, dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Final, NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.spelling import nearest, one_of


class QuantityError(UsageError, ValueError):
    """Raised for text that is not a quantity, or a quantity of the wrong dimension."""

    def __init__(self, message: str, suggestion: str = "") -> None:
        self.message = message
        self.suggestion = suggestion  # text to write instead, empty when there is none
        super().__init__(f"{message}; did you mean '{suggestion}'?" if suggestion else message)


@dataclass(frozen=True, slots=True)
class Dimension:
    """A dimension as exponents of the base quantities."""

    length: int = 0
    mass: int = 0
    time: int = 0
    current: int = 0
    angle: int = 0

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(*(a + b for a, b in zip(astuple(self), astuple(other), strict=True)))

    def __truediv__(self, other: Dimension) -> Dimension:
        return Dimension(*(a - b for a, b in zip(astuple(self), astuple(other), strict=True)))

    def __pow__(self, exponent: int) -> Dimension:
        return Dimension(*(a * exponent for a in astuple(self)))

    def __str__(self) -> str:
        """Return the dimension in SI base units, in a form `parse_unit` reads; '' when bare."""
        factors = list(zip(("m", "kg", "s", "A", "rad"), astuple(self), strict=True))
        above = [_power(unit, exponent) for unit, exponent in factors if exponent > 0]
        below = [_power(unit, -exponent) for unit, exponent in factors if exponent < 0]
        if not above and not below:
            return ""
        return "/".join(["*".join(above) or "1", *below])


def _power(unit: str, exponent: int) -> str:
    return unit if exponent == 1 else f"{unit}^{exponent}"


class Quantity(NamedTuple):
    """A value in SI units with its dimension."""

    value: float
    dimension: Dimension


DIMENSIONLESS: Final = Dimension()
LENGTH: Final = Dimension(length=1)
MASS: Final = Dimension(mass=1)
TIME: Final = Dimension(time=1)
CURRENT: Final = Dimension(current=1)
ANGLE: Final = Dimension(angle=1)
FREQUENCY: Final = DIMENSIONLESS / TIME
SPEED: Final = LENGTH / TIME
ACCELERATION: Final = SPEED / TIME
ANGULAR_SPEED: Final = ANGLE / TIME
ANGULAR_ACCELERATION: Final = ANGULAR_SPEED / TIME
FORCE: Final = MASS * ACCELERATION
TORQUE: Final = FORCE * LENGTH
STIFFNESS: Final = TORQUE / ANGLE
FORCE_PER_LENGTH: Final = FORCE / LENGTH
DAMPING: Final = MASS / TIME
INERTIA: Final = MASS * LENGTH**2
VOLTAGE: Final = TORQUE / TIME / CURRENT
MOTOR_CONSTANT: Final = TORQUE / CURRENT
VELOCITY_GAIN: Final = TORQUE / SPEED

# Per dimension its name, the unit of displayed values, and an example for messages.
_KNOWN: Final[dict[Dimension, tuple[str, str, str]]] = {
    DIMENSIONLESS: ("a bare number", "", "0.6"),
    LENGTH: ("a length", "m", "120 mm"),
    MASS: ("a mass", "kg", "130 g"),
    TIME: ("a duration", "s", "2 s"),
    CURRENT: ("a current", "A", "250 mA"),
    ANGLE: ("an angle", "rad", "28 deg"),
    FREQUENCY: ("a frequency", "Hz", "50 Hz"),
    SPEED: ("a speed", "m/s", "80 mm/s"),
    ACCELERATION: ("an acceleration", "m/s^2", "9.81 m/s^2"),
    ANGULAR_SPEED: ("an angular speed", "rad/s", "3 rad/s"),
    ANGULAR_ACCELERATION: ("an angular acceleration", "rad/s^2", "3 rad/s^2"),
    FORCE: ("a force", "N", "12 N"),
    TORQUE: ("a torque", "Nm", "0.8 Nm"),
    STIFFNESS: ("a torsional stiffness", "Nm/rad", "0.2 Nm/rad"),
    FORCE_PER_LENGTH: ("a stiffness", "N/m", "500 N/m"),
    DAMPING: ("a damping", "kg/s", "100 kg/s"),
    INERTIA: ("a moment of inertia", "kg*m^2", "2.88e-6 kg*m^2"),
    VOLTAGE: ("a voltage", "V", "6 V"),
    MOTOR_CONSTANT: ("a motor constant", "Nm/A", "8.44e-3 Nm/A"),
    VELOCITY_GAIN: ("a gain of a velocity law", "Nm*s/m", "6 Nm*s/m"),
}

UNITS: Final = MappingProxyType(
    {
        "1": Quantity(1.0, DIMENSIONLESS),
        "%": Quantity(1e-2, DIMENSIONLESS),
        "um": Quantity(1e-6, LENGTH),
        "mm": Quantity(1e-3, LENGTH),
        "cm": Quantity(1e-2, LENGTH),
        "m": Quantity(1.0, LENGTH),
        "deg": Quantity(math.pi / 180.0, ANGLE),
        "°": Quantity(math.pi / 180.0, ANGLE),
        "rad": Quantity(1.0, ANGLE),
        "mrad": Quantity(1e-3, ANGLE),
        "rev": Quantity(2.0 * math.pi, ANGLE),
        "us": Quantity(1e-6, TIME),
        "ms": Quantity(1e-3, TIME),
        "s": Quantity(1.0, TIME),
        "min": Quantity(60.0, TIME),
        "h": Quantity(3600.0, TIME),
        "Hz": Quantity(1.0, FREQUENCY),
        "kHz": Quantity(1e3, FREQUENCY),
        "g": Quantity(1e-3, MASS),
        "kg": Quantity(1.0, MASS),
        "mN": Quantity(1e-3, FORCE),
        "N": Quantity(1.0, FORCE),
        "mNm": Quantity(1e-3, TORQUE),
        "Nm": Quantity(1.0, TORQUE),
        "uA": Quantity(1e-6, CURRENT),
        "mA": Quantity(1e-3, CURRENT),
        "A": Quantity(1.0, CURRENT),
        "mV": Quantity(1e-3, VOLTAGE),
        "V": Quantity(1.0, VOLTAGE),
    }
)

# Spellings for which difflib does not find the right unit.
_LONG_NAMES: Final = MappingProxyType(
    {
        **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
        **dict.fromkeys(("millimeter", "millimeters", "millimetre", "millimetres"), "mm"),
        **dict.fromkeys(("centimeter", "centimeters", "centimetre", "centimetres"), "cm"),
        **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
        **dict.fromkeys(("msec", "millisecond", "milliseconds"), "ms"),
        **dict.fromkeys(("mins", "minute", "minutes"), "min"),
        **dict.fromkeys(("hr", "hour", "hours"), "h"),
        **dict.fromkeys(("degree", "degrees", "grad"), "deg"),
        **dict.fromkeys(("radian", "radians"), "rad"),
        **dict.fromkeys(("percent", "pct"), "%"),
        **dict.fromkeys(("ampere", "amperes", "amp", "amps"), "A"),
        **dict.fromkeys(("volt", "volts"), "V"),
        **dict.fromkeys(("newton", "newtons"), "N"),
        **dict.fromkeys(("nmm",), "mNm"),
        **dict.fromkeys(("gram", "grams"), "g"),
        **dict.fromkeys(("hertz",), "Hz"),
    }
)

_PREFIXES: Final = "kmgnpu"
"""Prefixes of units in small letters, from giga to pico."""

_NUMBER: Final = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_FACTOR: Final = re.compile(r"(1|%|°|[A-Za-zµ]+)(?:\^(-?[0-9]))?")
_LONGEST_TEXT: Final = 80


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Quantity:
    """Return the factor to SI and the dimension of a unit such as `mm`, `Nm/rad` or `m/s^2`.

    `*` and `/` apply from left to right; the exponent after `^` is an integer of one digit.

    Raises:
        QuantityError: The text is not a unit.
    """
    value, dimension = 1.0, DIMENSIONLESS
    for operator, factor in _factors(text):
        part = _unit_power(factor, text)
        if operator == "/":
            value, dimension = value / part.value, dimension / part.dimension
        else:
            value, dimension = value * part.value, dimension * part.dimension
    return Quantity(value, dimension)


def _factors(text: str) -> list[tuple[str, str]]:
    """Return the factors of a unit, each with the operator in front of it."""
    pieces = re.split(r"\s*([*/·])\s*", text.strip())
    return list(zip(["*", *pieces[1::2]], pieces[0::2], strict=True))


def _unit_power(factor: str, whole: str) -> Quantity:
    match = _FACTOR.fullmatch(factor)
    if match is None:
        raise QuantityError(f"'{_short(whole)}' is not a unit")
    name, exponent = match[1], int(match[2] or 1)
    unit = UNITS.get(name)
    if unit is None:
        suggestion = nearest_unit(name)
        better = whole.replace(name, suggestion, 1) if suggestion else ""
        raise QuantityError(f"unknown unit '{_short(name)}'", better)
    return Quantity(unit.value**exponent, unit.dimension**exponent)


def nearest_unit(name: str) -> str:
    """Return the unit that `name` most likely stands for, or '' when none is close.

    A unit of another size is none: `3 km` is not `3 m`.
    """
    name = name.replace("µ", "u")
    close = _LONG_NAMES.get(name.lower()) or nearest(name, UNITS) or ""
    sized = name[:1].lower() in _PREFIXES and name[1:].lower() == close.lower()
    return "" if sized else close


def parse_quantity(text: str) -> Quantity:
    """Return the SI value and the dimension of text such as `120 mm`; a bare number has none.

    Raises:
        QuantityError: The text is not a number with a unit, or the SI value is not finite.
    """
    stripped = text.strip()
    match = _NUMBER.match(stripped)
    if match is None or len(stripped) > _LONGEST_TEXT:
        raise QuantityError(f"expected a number with a unit such as '120 mm', got '{_short(text)}'")
    number, unit_text = match[0], stripped[match.end() :].strip()
    try:
        unit = parse_unit(unit_text) if unit_text else Quantity(1.0, DIMENSIONLESS)
    except QuantityError as error:
        better = f"{number} {error.suggestion}" if error.suggestion else ""
        raise QuantityError(f"{error.message} in '{_short(text)}'", better) from None
    value = float(number) * unit.value
    if not math.isfinite(value):
        raise QuantityError(f"'{_short(text)}' is not a finite number")
    return Quantity(value, unit.dimension)


def read_quantity(text: str, dimension: Dimension) -> float:
    """Return the SI value of `text`, which must be a quantity of `dimension`.

    Raises:
        QuantityError: The text is not a quantity, or its unit is missing or of another dimension.
    """
    expected = expectation(dimension)
    try:
        quantity = parse_quantity(text)
    except QuantityError as error:
        suggestion = error.suggestion if _fits(error.suggestion, dimension) else ""
        detail = f" ({error.message})" if error.message.startswith("unknown unit") else ""
        message = f"expected {expected}, got '{_short(text)}'{detail}"
        raise QuantityError(message, suggestion) from None
    if quantity.dimension != dimension:
        raise QuantityError(f"expected {expected}, got {_what(text, quantity)}")
    return quantity.value


def in_unit_of(text: str, value: float) -> str:
    """Return an SI value with the unit of a quantity as written: `50 %` for 0.5 and `120 %`.

    A value that is no short number in that unit has its SI unit.

    Raises:
        QuantityError: The text is not a quantity.
    """
    dimension = parse_quantity(text).dimension
    stripped = text.strip()
    match = _NUMBER.match(stripped)
    unit = stripped[match.end() :].strip() if match else ""
    number = value / (parse_unit(unit).value if unit else 1.0)
    short = f"{number:.4g}"
    if not math.isclose(float(short), number, rel_tol=1e-12):
        return format_quantity(value, dimension)
    return f"{short} {unit}".strip()


def _fits(text: str, dimension: Dimension) -> bool:
    try:
        return parse_quantity(text).dimension == dimension
    except QuantityError:
        return False


def _what(text: str, quantity: Quantity) -> str:
    shown = f"'{_short(text.strip())}'"
    if quantity.dimension == DIMENSIONLESS:
        return f"{shown}, a ratio" if "%" in text else f"{shown} without a unit"
    return f"{shown}, {describe(quantity.dimension)}"


def format_quantity(value: float, dimension: Dimension) -> str:
    """Return the quantity as text in its SI unit; `read_quantity` returns exactly `value` again."""
    unit = _KNOWN[dimension][1] if dimension in _KNOWN else str(dimension)
    return f"{value!r} {unit}".strip()


def in_degrees(value_rad: float) -> str:
    """Return an angle in degrees: `12.5°`."""
    return f"{round(math.degrees(value_rad), 3):g}°"


def unit_of(dimension: Dimension) -> str:
    """Return the SI unit of displayed values of a dimension; empty if it has none."""
    return format_quantity(1.0, dimension).partition(" ")[2]


def describe(dimension: Dimension) -> str:
    """Return the dimension in words, with its article: `a length`."""
    return _KNOWN[dimension][0] if dimension in _KNOWN else f"a quantity in {dimension}"


def example(dimension: Dimension) -> str:
    """Return a typical quantity of the dimension as a person would write it: `120 mm`."""
    return _KNOWN[dimension][2] if dimension in _KNOWN else f"1 {dimension}"


def expectation(dimension: Dimension) -> str:
    """Return the expected input for messages: `a length such as '120 mm'`."""
    return f"{describe(dimension)} such as '{example(dimension)}'"


def units_of(dimension: Dimension) -> str:
    """Return the usual units of a dimension for messages: `one of mm, cm, m`."""
    plain = [name for name, unit in UNITS.items() if unit.dimension == dimension]
    composed = (example(dimension).partition(" ")[2], unit_of(dimension))
    return one_of(plain or dict.fromkeys(filter(None, composed)))


def _short(text: str) -> str:
    clean = " ".join(text.split())
    return clean if len(clean) <= 40 else f"{clean[:39]}…"
