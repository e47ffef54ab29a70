"""Quantities as people write them."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core import units
from pirate_sm.core.units import (
    Dimension,
    Quantity,
    QuantityError,
    format_quantity,
    parse_quantity,
    parse_unit,
    read_quantity,
)

NAMED = [
    units.DIMENSIONLESS, units.LENGTH, units.MASS, units.TIME, units.CURRENT, units.ANGLE,
    units.FREQUENCY, units.SPEED, units.ACCELERATION, units.ANGULAR_SPEED,
    units.ANGULAR_ACCELERATION, units.FORCE, units.TORQUE, units.STIFFNESS,
    units.FORCE_PER_LENGTH, units.DAMPING, units.INERTIA, units.VOLTAGE, units.MOTOR_CONSTANT,
]  # fmt: skip
EXPONENT = st.integers(-3, 3)
DIMENSIONS = st.builds(Dimension, EXPONENT, EXPONENT, EXPONENT, EXPONENT, EXPONENT)
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@pytest.mark.parametrize(
    ("text", "value", "dimension"),
    [
        ("120 mm", 0.12, units.LENGTH),
        ("120mm", 0.12, units.LENGTH),
        (" -2.5 cm ", -0.025, units.LENGTH),
        ("180 deg", math.pi, units.ANGLE),
        ("90 °", math.pi / 2, units.ANGLE),
        ("10 min", 600.0, units.TIME),
        ("200 ms", 0.2, units.TIME),
        ("60 %", 0.6, units.DIMENSIONLESS),
        ("0.6", 0.6, units.DIMENSIONLESS),
        ("1e-3 kg", 1e-3, units.MASS),
        ("80 mm/s", 0.08, units.SPEED),
        ("9.81 m/s^2", 9.81, units.ACCELERATION),
        ("9.81 m/s/s", 9.81, units.ACCELERATION),
        ("180 deg/s", math.pi, units.ANGULAR_SPEED),
        ("250 mA", 0.25, units.CURRENT),
        ("3 mNm", 3e-3, units.TORQUE),
        ("3 N*m", 3.0, units.TORQUE),
        ("3 N·m", 3.0, units.TORQUE),
        ("1 Nm/deg", 180 / math.pi, units.STIFFNESS),
        ("500 N/m", 500.0, units.FORCE_PER_LENGTH),
        ("2.88e-6 kg*m^2", 2.88e-6, units.INERTIA),
        ("3.0e-3 Nm/A", 3.0e-3, units.MOTOR_CONSTANT),
        ("100 kg/s", 100.0, units.DAMPING),
        ("62 Hz", 62.0, units.FREQUENCY),
        ("6 V", 6.0, units.VOLTAGE),
    ],
)
def test_a_quantity_is_read_into_si(text: str, value: float, dimension: Dimension) -> None:
    assert parse_quantity(text) == Quantity(pytest.approx(value, rel=1e-15), dimension)


@pytest.mark.parametrize(
    "text",
    ["", "mm", "12 13 mm", "1,5 m", "nan m", "inf", "1e999 m", "12 m^", "12 m^22", "1 m//s",
     "0x10 m", "1_000 mm", "1 m s", "9" * 500, "1e308 h"],
)  # fmt: skip
def test_what_is_no_finite_quantity_is_refused(text: str) -> None:
    with pytest.raises(QuantityError):
        parse_quantity(text)


@pytest.mark.parametrize(
    ("text", "suggestion"),
    [
        ("2 sec", "2 s"),
        ("90 degrees", "90 deg"),
        ("12 MM", "12 mm"),
        ("5 meters", "5 m"),
        ("3 metres/second", "3 m/second"),
        ("7 furlongs", ""),
    ],
)
def test_an_unknown_unit_gets_the_nearest_one(text: str, suggestion: str) -> None:
    with pytest.raises(QuantityError, match="unknown unit") as raised:
        parse_quantity(text)

    assert raised.value.suggestion == suggestion


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("120", "expected a length such as '120 mm', got '120' without a unit"),
        ("3 s", "expected a length such as '120 mm', got '3 s', a duration"),
        ("50 %", "expected a length such as '120 mm', got '50 %', a ratio"),
        ("long", "expected a length such as '120 mm', got 'long'"),
        ("3 A*m", "expected a length such as '120 mm', got '3 A*m', a quantity in m*A"),
    ],
)
def test_a_quantity_of_another_dimension_is_refused_in_words(text: str, message: str) -> None:
    with pytest.raises(QuantityError) as raised:
        read_quantity(text, units.LENGTH)

    assert raised.value.message == message


def test_a_suggestion_has_the_dimension_that_was_asked_for() -> None:
    with pytest.raises(QuantityError) as meant_a_length:
        read_quantity("5 meters", units.LENGTH)
    with pytest.raises(QuantityError) as meant_a_time:
        read_quantity("5 seconds", units.LENGTH)

    assert meant_a_length.value.suggestion == "5 m"
    assert meant_a_time.value.suggestion == ""


@pytest.mark.parametrize("dimension", NAMED, ids=units.describe)
def test_the_example_of_a_dimension_is_one_of_it(dimension: Dimension) -> None:
    assert math.isfinite(read_quantity(units.example(dimension), dimension))


@given(value=FINITE, dimension=st.one_of(DIMENSIONS, st.sampled_from(NAMED)))
def test_a_written_quantity_is_read_back_exactly(value: float, dimension: Dimension) -> None:
    assert read_quantity(format_quantity(value, dimension), dimension) == value


@given(value=st.floats(-1e6, 1e6), unit=st.sampled_from(sorted(units.UNITS)))
def test_every_unit_scales_by_its_factor(value: float, unit: str) -> None:
    factor, dimension = parse_unit(unit)

    assert parse_quantity(f"{value!r} {unit}") == Quantity(value * factor, dimension)


@given(DIMENSIONS, DIMENSIONS)
def test_dimensions_multiply_as_units_do(first: Dimension, second: Dimension) -> None:
    assert first * second / second == first
    assert first**2 == first * first
    assert (first / first) == units.DIMENSIONLESS


@given(st.text(max_size=100))
def test_no_text_raises_anything_but_a_quantity_error(text: str) -> None:
    try:
        value, message = parse_quantity(text).value, ""
    except QuantityError as error:
        value, message = 0.0, error.message
    assert math.isfinite(value)
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "dimension", "meant"),
    [
        ("3 km", units.LENGTH, ""),
        ("3 KN", units.FORCE, ""),
        ("3 mg", units.MASS, ""),
        ("3 krad", units.ANGLE, ""),
        ("3 Nmm", units.TORQUE, "3 mNm"),
        ("120 MM", units.LENGTH, "120 mm"),
        ("5 µm", units.LENGTH, "5 um"),
        ("1.2 rads", units.ANGLE, "1.2 rad"),
        ("3 mrads", units.ANGLE, "3 mrad"),
    ],
)
def test_no_unit_of_another_size_is_suggested(text: str, dimension: Dimension, meant: str) -> None:
    with pytest.raises(QuantityError) as caught:
        read_quantity(text, dimension)

    assert caught.value.suggestion == meant
