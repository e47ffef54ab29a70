"""Column names with their SI unit, in characters that every program accepts in a name."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.expressions import NumberType
from pirate_sm.units import DIMENSIONLESS, Dimension, format_quantity


@cache
def with_unit(name: str, dimension: Dimension) -> str:
    """Return the name with the SI unit of its dimension; alone if it has none."""
    unit = format_quantity(1.0, dimension).partition(" ")[2]
    unit = unit.replace("/", "_per_").replace("^", "").replace("*", "_")
    return f"{name}_{unit}" if unit else name


def signal_names(robot: RobotSpec, names: Iterable[str] | None = None) -> tuple[str, ...]:
    """Return the column names of these signals; by default of all, in the engine's order."""
    types = robot.vocabulary.types
    named = []
    for name in robot.vocabulary.numbers if names is None else names:
        kind = types[name]
        dimension = kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS
        named.append(with_unit(name, dimension))
    return tuple(named)


def slot_names(robot: RobotSpec) -> tuple[str, ...]:
    """Return the column names of all setpoints."""
    units = {"duty": "duty", "angle": "rad"}
    return tuple(f"{slot.name}_{units[slot.unit]}" for slot in robot.slots)
