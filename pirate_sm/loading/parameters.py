"""A mission's parameters get their values: defaults, ``--set``, or the arguments of a call."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pirate_sm.loading.problems import Path, Problems
from pirate_sm.model.mission import ParameterDefinition, ParameterValue
from pirate_sm.spelling import nearest, one_of
from pirate_sm.units import (
    ANGLE,
    ANGULAR_SPEED,
    CURRENT,
    DIMENSIONLESS,
    FORCE,
    LENGTH,
    SPEED,
    TIME,
    TORQUE,
    Dimension,
    Quantity,
    QuantityError,
    describe,
    read_quantity,
)

DIMENSIONS: Mapping[str, Dimension] = {
    "duration": TIME, "length": LENGTH, "angle": ANGLE, "speed": SPEED,
    "angular_speed": ANGULAR_SPEED, "torque": TORQUE, "force": FORCE, "current": CURRENT,
    "ratio": DIMENSIONLESS, "count": DIMENSIONLESS, "number": DIMENSIONLESS,
}  # fmt: skip


class Value(NamedTuple):
    """A parameter's value in SI, and as somebody wrote it."""

    quantity: Quantity
    text: str


Values = dict[str, Value]


def read_value(definition: ParameterDefinition, value: ParameterValue) -> Quantity:
    """The value in SI, of the parameter's dimension and within its limits.

    Raises:
        QuantityError: It is not.
    """
    quantity = _read(definition.type, value)
    low, high = definition.min, definition.max
    if low is not None and quantity.value < _read(definition.type, low).value:
        raise QuantityError(f"{value} is less than the min of {low}")
    if high is not None and quantity.value > _read(definition.type, high).value:
        raise QuantityError(f"{value} is more than the max of {high}")
    return quantity


def _read(kind: str, value: ParameterValue) -> Quantity:
    dimension = DIMENSIONS[kind]
    if kind == "count":
        text = str(value)
        if not text.isdigit():
            raise QuantityError(f"expected a whole number such as 3, got '{value}'")
        return Quantity(float(text), dimension)
    if isinstance(value, bool):
        raise QuantityError(f"expected a {kind}, got '{value}'")
    return Quantity(read_quantity(str(value), dimension), dimension)


def defaults(definitions: Mapping[str, ParameterDefinition], problems: Problems) -> Values:
    """The defaults in SI; a default or limit that does not fit is a problem at its place."""
    values: Values = {}
    for name, definition in definitions.items():
        for key in ("min", "max", "default"):
            given = getattr(definition, key)
            if given is None:
                continue
            try:
                quantity = (read_value if key == "default" else _plain)(definition, given)
            except QuantityError as error:
                problems.add("mission.parameter", ("parameters", name, key), str(error))
                continue
            if key == "default":
                values[name] = Value(quantity, str(given))
    return values


def _plain(definition: ParameterDefinition, value: ParameterValue) -> Quantity:
    return _read(definition.type, value)


def given(
    definitions: Mapping[str, ParameterDefinition],
    arguments: Mapping[str, Value | ParameterValue],
    path: Path,
    problems: Problems,
) -> Values:
    """The arguments in SI; an unknown name or a value that does not fit is a problem."""
    values: Values = {}
    for name, argument in arguments.items():
        definition = definitions.get(name)
        if definition is None:
            problems.add(
                "mission.parameter", (*path, name), f"there is no parameter '{name}'",
                expected=one_of(definitions) if definitions else "no parameters",
                suggestion=nearest(name, definitions) or "", key=True,
            )  # fmt: skip
            continue
        try:
            text = argument.text if isinstance(argument, Value) else str(argument)
            values[name] = Value(read_argument(definition, argument), text)
        except QuantityError as error:
            problems.add("mission.parameter", (*path, name), f"parameter '{name}': {error}")
    return values


def read_argument(definition: ParameterDefinition, argument: Value | ParameterValue) -> Quantity:
    """An argument, written out or handed on from a caller's parameter, in SI.

    Raises:
        QuantityError: It does not fit.
    """
    if not isinstance(argument, Value):
        return read_value(definition, argument)
    dimension = argument.quantity.dimension
    if dimension != DIMENSIONS[definition.type]:
        raise QuantityError(f"expected a {definition.type}, got {describe(dimension)}")
    return read_value(definition, argument.text)
