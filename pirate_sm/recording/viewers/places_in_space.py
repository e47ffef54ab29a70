"""The columns of the topic with the wheels' places beside x and y: z in space, and rolls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pirate_sm.model.true_position import InSpace

ROLLS = ("joint_roll_rad", "front_roll_rad", "rear_roll_rad")


def columns_in_space(wheels: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the columns: z of each wheel, then the rolls."""
    return (*(f"{name}_z_m" for name in wheels), *ROLLS)


def values_in_space(space: InSpace) -> tuple[float, ...]:
    """Return the values of these columns."""
    return (*space.z_m, *space.rolls_rad)


def space_of(content: Mapping[str, Any], wheels: Sequence[str]) -> InSpace | None:
    """Return what a message has in these columns; None if it is of a robot in a plane."""
    names = columns_in_space(wheels)
    if any(name not in content for name in names):
        return None
    values = tuple(float(content[name]) for name in names)
    return InSpace(values[: len(wheels)], values[len(wheels) :])


def rolls_of(content: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the rolls in a message; empty if it has none."""
    return tuple(float(content[name]) for name in ROLLS) if content.keys() >= {*ROLLS} else ()
