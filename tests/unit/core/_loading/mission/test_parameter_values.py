"""Parameters: of their type, within their limits, said where they are not."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._loading.mission.parameter_values import (
    DIMENSIONS,
    Value,
    read_argument,
    read_value,
)
from pirate_sm.core._model.mission import ParameterDefinition
from pirate_sm.core.units import LENGTH, TIME, Quantity, QuantityError

HEAD = "format: 1\nmission: m\nrobot: pirate_ii\n"


def mission(definition: str, use: str = "ClampFront") -> str:
    return (
        f"{HEAD}parameters:\n  p: {definition}\nstart: a\n"
        f"phases: {{a: {{do: [{use}], go: e}}}}\nends: {{e: {{succeed: ok}}}}\n"
    )


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        ("duration", "2 min", 120.0),
        ("length", "12 cm", 0.12),
        ("angle", "180 deg", math.pi),
        ("speed", "5 mm/s", 0.005),
        ("angular_speed", "1 rev/s", 2 * math.pi),
        ("torque", "500 mNm", 0.5),
        ("force", "2 N", 2.0),
        ("current", "150 mA", 0.15),
        ("ratio", "60 %", 0.6),
        ("ratio", 0.6, 0.6),
        ("count", 3, 3.0),
        ("count", "3", 3.0),
        ("number", 1.5, 1.5),
        ("number", -2, -2.0),
    ],
)
def test_a_value_is_read_in_si(kind, text, value):
    quantity = read_value(ParameterDefinition(type=kind), text)

    assert quantity.value == pytest.approx(value)
    assert quantity.dimension == DIMENSIONS[kind]


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("duration", "5"), ("duration", 5), ("duration", "5 mm"), ("duration", "five s"),
        ("length", ""), ("length", "1e999 m"), ("count", "3.0"), ("count", 3.5), ("count", "-1"),
        ("count", "²"), ("count", "٣"), ("count", "9" * 400), ("count", "3 s"), ("count", ""),
        ("number", "nan"), ("number", math.inf), ("number", "1 m"), ("ratio", "1 m"),
    ],
)  # fmt: skip
def test_a_value_of_another_kind_is_refused(kind, text):
    with pytest.raises(QuantityError):
        read_value(ParameterDefinition(type=kind), text)


def test_limits_are_inclusive():
    definition = ParameterDefinition(type="duration", min="1 s", max="1 min")

    assert read_value(definition, "1 s").value == 1
    assert read_value(definition, "60 s").value == 60
    with pytest.raises(QuantityError, match="999 ms is less than the min of 1 s"):
        read_value(definition, "999 ms")
    with pytest.raises(QuantityError, match="61 s is more than the max of 1 min"):
        read_value(definition, "61 s")


@pytest.mark.parametrize("kind", sorted(DIMENSIONS))
@given(text=st.text(max_size=12))
def test_any_text_is_read_or_refused(kind, text):
    try:
        value = read_value(ParameterDefinition(type=kind), text).value
    except QuantityError:
        return
    assert math.isfinite(value)


def test_an_argument_that_is_handed_on_must_be_of_the_kind_and_within_the_limits():
    definition = ParameterDefinition(type="duration", max="10 s")

    handed = read_argument(definition, Value(Quantity(5.0, TIME), "5 s"))
    assert handed == Quantity(5.0, TIME)
    with pytest.raises(QuantityError, match="expected a duration, got a length"):
        read_argument(definition, Value(Quantity(5.0, LENGTH), "5 m"))
    with pytest.raises(QuantityError, match="more than the max"):
        read_argument(definition, Value(Quantity(20.0, TIME), "20 s"))


@pytest.mark.parametrize(
    ("definition", "use", "faults_told"),
    [
        ("{type: duration, default: 5}", "{command: Brake, timeout: $p}",
         ["5:32: expected a duration such as '2 s', got '5' without a unit"]),
        ("{type: duration, default: 5 s, min: 10 s}", "Brake",
         ["5:32: 5 s is less than the min of 10 s"]),
        ("{type: duration, default: 5 s, min: 10}", "Brake",
         ["5:42: expected a duration such as '2 s', got '10' without a unit"]),
        ("{type: duration, default: 7 s, min: 10 s, max: 5 s}", "Brake",
         ["5:53: the max of 5 s is less than the min of 10 s"]),
        ("{type: time, default: 5 s}", "Brake", ["5:13: expected one of duration, length, angle"]),
        ("{type: count, default: true}", "Brake", ["5:29: expected text or a whole number or a"]),
        ("{type: count, default: [1]}", "Brake", ["5:29: expected text or a whole number or a"]),
        ("{default: 5 s}", "Brake", ["5:3: the key 'type' is missing"]),
        ("{type: length, default: 5 m}", "{command: Brake, timeout: $p}",
         ["7:45: $p is a length"]),
        ("{type: ratio, default: 0.5}", "{repeat: {times: $p, do: [Brake]}}",
         ["7:36: $p is no count"]),
        ("{type: number, default: -2}", "{command: Brake, retry: $p}", ["7:43: $p is no count"]),
        ("{type: count, default: 2}", "{command: Brake, if: odometry > $p}",
         ["7:49: cannot compare a length and a bare number"]),
        ("{type: duration, default: -5 s}", "{command: Brake, timeout: $p}",
         ["7:45: expected at least 16 ms, one cycle of the robot's bus, got -5 s"]),
        ("{type: duration, default: -1.5 s}", "{command: Brake, timeout: $p}",
         ["7:45: expected at least 16 ms, one cycle of the robot's bus, got -1.5 s"]),
    ],
)  # fmt: skip
def test_a_fault_of_a_parameter_is_told_once_and_where_it_stands(
    faults, definition, use, faults_told
):
    said = faults(mission(definition, use))

    assert len(said) == len(faults_told), said
    for each, told in zip(said, faults_told, strict=True):
        assert each.startswith(f"m.yaml:{told}")


def test_a_parameter_cannot_be_named_like_what_was_driven(faults):
    text = mission("{type: duration, default: 5 s}").replace("  p:", "  driven:")
    means = "how far the robot has driven, as measured, with its bound"
    assert faults(text) == [f"m.yaml:5:3: '{{driven}}' is {means}: choose another name"]


def test_a_parameter_cannot_be_named_like_the_cause(faults):
    text = mission("{type: duration, default: 5 s}").replace("  p:", "  cause:")

    assert faults(text) == ["m.yaml:5:3: '{cause}' is why something failed: choose another name"]


@pytest.mark.parametrize(
    ("given_text", "message"),
    [
        ("5", "without a unit"),
        ("5 mm", "a duration"),
        ("1 h", "1 h is more than the max of 10 min"),
        ("", "a duration"),
    ],
)
def test_a_setting_that_does_not_fit_is_told_with_its_name(faults, given_text, message):
    text = mission("{type: duration, default: 5 s, max: 10 min}")

    (said,) = faults(text, settings={"p": given_text})

    assert said.startswith("parameter 'p': ")
    assert message in said
