"""Evaluate parameters from defaults, ``--set``, or the arguments of a call."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._model.mission import DIMENSIONS, ParameterDefinition, ParameterValue
from pirate_sm.core._model.quantities import read_quantity
from pirate_sm.core.units import Quantity, QuantityError, describe

_COUNT = re.compile(r"[0-9]{1,9}")


class Value(NamedTuple):
    """A parameter's value in SI units, and as written."""

    quantity: Quantity
    text: str


Values = dict[str, Value]


def read_value(definition: ParameterDefinition, value: ParameterValue) -> Quantity:
    """Return a value in SI units, checked against the parameter's dimension and limits.

    Raises:
        QuantityError: The value does not fit.
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
        if not _COUNT.fullmatch(text):
            raise QuantityError(f"expected a whole number such as 3, got '{value}'")
        return Quantity(float(text), dimension)
    return Quantity(read_quantity(str(value), dimension), dimension)


def defaults(definitions: Mapping[str, ParameterDefinition], problems: Problems) -> Values:
    """Return the defaults in SI units; report each default or limit that does not fit."""
    values: Values = {}
    for name, definition in definitions.items():
        limits_fit = _check_limits(name, definition, problems)
        if definition.default is None:
            continue
        values[name] = stand_in(definition)
        try:
            unbounded = ParameterDefinition(type=definition.type)
            quantity = read_value(definition if limits_fit else unbounded, definition.default)
        except QuantityError as error:
            path = ("parameters", name, "default")
            problems.add("mission.parameter", path, error.message, suggestion=error.suggestion)
            continue
        values[name] = Value(quantity, str(definition.default))
    return values


def _check_limits(name: str, definition: ParameterDefinition, problems: Problems) -> bool:
    """Return whether both limits are valid and in order; report a fault otherwise."""
    limits: dict[str, float] = {}
    for key, limit in (("min", definition.min), ("max", definition.max)):
        if limit is None:
            continue
        try:
            limits[key] = _read(definition.type, limit).value
        except QuantityError as error:
            path = ("parameters", name, key)
            problems.add("mission.parameter", path, error.message, suggestion=error.suggestion)
            return False
    if len(limits) == 2 and limits["max"] < limits["min"]:
        message = f"the max of {definition.max} is less than the min of {definition.min}"
        problems.add("mission.parameter", ("parameters", name, "max"), message)
        return False
    return True


def stand_in(definition: ParameterDefinition) -> Value:
    """Return a substitute for a faulty value, so that its uses are not reported as well."""
    return Value(Quantity(1.0, DIMENSIONS[definition.type]), "")


def sample(definition: ParameterDefinition) -> Value:
    """Return a value for a parameter without a default: one of its limits, else 1."""
    for limit in (definition.min, definition.max):
        try:
            if limit is not None:
                return Value(read_value(definition, limit), str(limit))
        except QuantityError:
            break  # reported already
    return stand_in(definition)


def given(
    definitions: Mapping[str, ParameterDefinition],
    arguments: Mapping[str, Value | ParameterValue],
    path: Path,
    problems: Problems,
) -> Values:
    """Return the arguments in SI units; report unknown names and values that do not fit."""
    values: Values = {}
    for name, argument in arguments.items():
        definition = definitions.get(name)
        if definition is None:
            problems.add_unknown(
                "mission.parameter",
                (*path, name),
                "parameter",
                name,
                definitions,
                none="no parameters",
                key=True,
            )
            continue
        try:
            text = argument.text if isinstance(argument, Value) else str(argument)
            values[name] = Value(read_argument(definition, argument), text)
        except QuantityError as error:
            values[name] = stand_in(definition)
            message = f"parameter '{name}': {error.message}"
            problems.add("mission.parameter", (*path, name), message, suggestion=error.suggestion)
    return values


def read_argument(definition: ParameterDefinition, argument: Value | ParameterValue) -> Quantity:
    """Return an argument in SI units, given as a value or as a parameter of the caller.

    Raises:
        QuantityError: It does not fit.
    """
    if not isinstance(argument, Value):
        return read_value(definition, argument)
    dimension = argument.quantity.dimension
    if dimension != DIMENSIONS[definition.type]:
        raise QuantityError(f"expected a {definition.type}, got {describe(dimension)}")
    return read_value(definition, argument.text)
