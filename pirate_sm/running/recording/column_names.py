"""Names of columns with their SI unit, in characters that every program accepts in a name."""

from __future__ import annotations

from functools import cache

from pirate_sm.core.profile import Profile
from pirate_sm.core.robot import RobotSpec
from pirate_sm.core.units import Dimension, unit_of


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
