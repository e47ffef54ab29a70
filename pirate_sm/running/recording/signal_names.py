"""Columns of values over time: their names with SI units, and a limited number of values."""

from __future__ import annotations

from functools import cache
from typing import TypeVar

from pirate_sm.core.models import Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.units import Dimension, unit_of

# --- names ----------------------------------------------------------------------------------------


@cache
def with_unit(name: str, dimension: Dimension) -> str:
    """Return the name with the SI unit of its dimension; alone if it has none."""
    unit = unit_of(dimension).replace("/", "_per_").replace("^", "").replace("*", "_")
    return f"{name}_{unit}" if unit else name


def signal_units(robot: RobotSpec) -> dict[str, str]:
    """Return the unit of each signal by its column name; empty for one that has none."""
    units = (unit_of(robot.vocabulary.dimension(name)) for name in robot.vocabulary.numbers)
    return dict(zip(signal_names(robot), units, strict=True))


def signal_names(robot: RobotSpec) -> tuple[str, ...]:
    """Return the column names of all signals, in the engine's order."""
    known = robot.vocabulary
    return tuple(with_unit(name, known.dimension(name)) for name in known.numbers)


def slot_names(robot: RobotSpec) -> tuple[str, ...]:
    """Return the column names of all setpoints."""
    units = {"duty": "duty", "angle": "rad"}
    return tuple(f"{slot.name}_{units[slot.unit]}" for slot in robot.slots)


def current_signals(profile: Profile, *, of_wheels: bool) -> list[str]:
    """Return the signals that are currents of wheels' motors, or of all others."""
    slots = {slot.name: slot for slot in profile.slots}
    return [
        channel.signal
        for board in profile.boards
        for channel in board.channels
        if channel.senses == "current"
        and channel.signal
        and channel.slot
        and (slots[channel.slot].wheel is not None) == of_wheels
    ]


# --- values ---------------------------------------------------------------------------------------


T = TypeVar("T")


def add_evenly(
    times_s: list[float], things: list[T], new: tuple[float, T], apart_s: float, most: int
) -> float:
    """Append the new value, remove values that are too close, and return the new spacing.

    Args:
        times_s: Times of the values, ascending.
        things: The values.
        new: Time and value to append.
        apart_s: The least spacing, except before the newest value.
        most: The largest number of values to keep.

    Returns:
        The least spacing from now on.
    """
    at_s, thing = new
    newest_only = len(times_s) > 1 and times_s[-1] < times_s[-2] + apart_s
    if times_s and (at_s <= times_s[-1] or newest_only):
        times_s.pop()
        things.pop()
    times_s.append(at_s)
    things.append(thing)
    if len(times_s) > most:
        apart_s = 2 * (times_s[-1] - times_s[0]) / len(times_s)
        del times_s[1:-1:2], things[1:-1:2]
    return apart_s
