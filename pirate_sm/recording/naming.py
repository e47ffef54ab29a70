"""Names of columns that say their unit, in characters that any program takes in a name."""

from __future__ import annotations

from pirate_sm.engine.robot.robot_spec import RobotSpec
from pirate_sm.expressions import NumberType
from pirate_sm.units import DIMENSIONLESS, Dimension, format_quantity


def with_unit(name: str, dimension: Dimension) -> str:
    """The name with the SI unit of its dimension; alone where it has none."""
    unit = format_quantity(1.0, dimension).partition(" ")[2]
    unit = unit.replace("/", "_per_").replace("^", "").replace("*", "_")
    return f"{name}_{unit}" if unit else name


def signal_names(robot: RobotSpec) -> tuple[str, ...]:
    """Every number that conditions can see, with its unit, in the order of the engine."""
    types = robot.vocabulary.types
    named = []
    for name in robot.vocabulary.numbers:
        kind = types[name]
        dimension = kind.dimension if isinstance(kind, NumberType) else DIMENSIONLESS
        named.append(with_unit(name, dimension))
    return tuple(named)


def slot_names(robot: RobotSpec) -> tuple[str, ...]:
    """Every setpoint with its unit."""
    units = {"duty": "duty", "angle": "rad"}
    return tuple(f"{slot.name}_{units[slot.unit]}" for slot in robot.slots)
