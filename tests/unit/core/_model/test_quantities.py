"""Field types of models: units in the file, SI floats in the program."""

from __future__ import annotations

import math
from typing import Annotated, Any

import pytest
from pydantic import Field, TypeAdapter, ValidationError

from pirate_sm.core._model import quantities
from pirate_sm.core._model.quantities import (
    FROM_FILE,
    Angle,
    AnyQuantity,
    Count,
    CountOrParameter,
    DurationOrParameter,
    Flag,
    Length,
    Number,
    Parameter,
    Ratio,
    Stiffness,
)
from pirate_sm.core.units import DIMENSIONLESS, LENGTH, Quantity


def read(kind: Any, value: object) -> Any:
    return TypeAdapter(kind).validate_python(value, context=dict(FROM_FILE))


def refusal(kind: Any, value: object) -> str:
    with pytest.raises(ValidationError) as raised:
        read(kind, value)
    (error,) = raised.value.errors()
    return str(error["msg"])


@pytest.mark.parametrize(
    ("kind", "written", "value"),
    [
        (Length, "120 mm", 0.12),
        (Angle, "-45 deg", -math.pi / 4),
        (Stiffness, "0.2 Nm/rad", 0.2),
        (Ratio, "60 %", 0.6),
        (Ratio, 0.6, 0.6),
        (Ratio, 1, 1.0),
        (Number, 3, 3.0),
        (Count, 3, 3),
        (Flag, True, True),
        (AnyQuantity, "120 mm", Quantity(0.12, LENGTH)),
        (AnyQuantity, 4, Quantity(4.0, DIMENSIONLESS)),
        (DurationOrParameter, "2 s", 2.0),
        (DurationOrParameter, "$patience", Parameter("patience")),
        (CountOrParameter, 2, 2),
        (CountOrParameter, "$tries", Parameter("tries")),
    ],
)
def test_a_file_gives_the_unit(kind: Any, written: object, value: object) -> None:
    assert read(kind, written) == value


@pytest.mark.parametrize(
    ("kind", "written", "message"),
    [
        (Length, 120, "expected a length such as '120 mm', got '120' without a unit"),
        (Length, 0, "expected a length such as '120 mm', got '0' without a unit"),
        (Length, "0", "expected a length such as '120 mm', got '0' without a unit"),
        (Length, "2 s", "expected a length such as '120 mm', got '2 s', a duration"),
        (Length, None, "expected a length such as '120 mm', got nothing"),
        (Length, True, "expected a length such as '120 mm', got 'true'"),
        (Length, ["1 m"], "expected a length such as '120 mm', got a list"),
        (Length, {"m": 1}, "expected a length such as '120 mm', got a mapping"),
        (Ratio, "0.6", "expected a ratio such as '60 %' or 0.6, got '0.6'"),
        (Ratio, math.nan, "expected a ratio such as '60 %' or 0.6, got 'nan'"),
        (Number, "60 %", "expected a bare number such as 0.6, got '60 %'"),
        (Number, math.inf, "expected a bare number, got 'inf'"),
        (DurationOrParameter, 3, "expected a duration such as '2 s', got '3' without a unit"),
        (DurationOrParameter, "$", "expected a parameter such as '$give_up', got '$'"),
        (CountOrParameter, -1, "expected a count of at least 0, got -1"),
        (CountOrParameter, "2 s", "expected a count such as 3, got '2 s'"),
        (AnyQuantity, "2 blinks", "unknown unit 'blinks' in '2 blinks'"),
    ],
)
def test_a_refusal_says_what_was_expected(kind: Any, written: object, message: str) -> None:
    assert refusal(kind, written) == message


@pytest.mark.parametrize("written", [True, "3", 3.0, -1])
def test_a_count_is_a_whole_number_and_nothing_else(written: object) -> None:
    with pytest.raises(ValidationError):
        read(Count, written)


@pytest.mark.parametrize("written", ["on", "yes", "true", 1])
def test_a_flag_is_true_or_false_and_nothing_else(written: object) -> None:
    with pytest.raises(ValidationError):
        read(Flag, written)


def test_a_program_passes_si() -> None:
    assert TypeAdapter(Length).validate_python(0.12) == 0.12
    with pytest.raises(ValidationError):
        TypeAdapter(Length).validate_python(math.nan)


def test_limits_are_in_si() -> None:
    bounded = TypeAdapter(Annotated[Length, Field(gt=0, le=0.2)])

    assert bounded.validate_python("200 mm") == 0.2
    with pytest.raises(ValidationError):
        bounded.validate_python("201 mm")


@pytest.mark.parametrize(
    "kind",
    [kind for name in dir(quantities) if (kind := getattr(quantities, name)) and name[0].isupper()
     and hasattr(kind, "__metadata__")],
)  # fmt: skip
def test_every_field_type_has_a_json_schema(kind: Any) -> None:
    assert TypeAdapter(kind).json_schema()
