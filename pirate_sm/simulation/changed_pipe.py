"""Gives the simulated pipe other numbers than its file, of which the mission knows nothing.

They are among the numbers of a run, by names that begin with ``pipe.``.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Final, NamedTuple

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.options import OF_PIPE
from pirate_sm.core.spelling import unknown
from pirate_sm.core.units import (
    ANGLE,
    DIMENSIONLESS,
    LENGTH,
    Dimension,
    QuantityError,
    format_quantity,
    read_quantity,
)
from pirate_sm.simulation.surroundings import Jitter


class _Bounds(NamedTuple):
    dimension: Dimension
    least: float
    most: float


PIPE_NUMBERS: Final[Mapping[str, _Bounds]] = {
    "friction": _Bounds(DIMENSIONLESS, 0.0, 5.0),
    "diameter": _Bounds(LENGTH, 0.01, 10.0),
    "tilt": _Bounds(ANGLE, -pi / 2, pi / 2),
    "roll": _Bounds(ANGLE, -pi, pi),
    "start": _Bounds(LENGTH, 0.0, 1000.0),
}
"""The numbers of a pipe and what they can be, as in its file; friction is the kinetic one."""

_MOST_OF_DIAMETER = 0.25
"""A diameter differs from its file by less than this share, else the robot is another [decided]."""


def numbers_of(pipe: Pipe, profile: Profile) -> dict[str, float]:
    """Return the numbers of a pipe by name, in SI units."""
    friction = pipe.friction or profile.simulation.friction
    return {
        "friction": friction.kinetic,
        "diameter": pipe.diameter,
        "tilt": pipe.tilt if pipe.frame is None else pipe.frame.pitch,
        "roll": pipe.roll,
        "start": pipe.start_of(sum(link.length for link in profile.body.links)),
    }


def changed_pipe(
    pipe: Pipe, profile: Profile, numbers: Mapping[str, str], jitter: Mapping[str, float]
) -> tuple[Pipe, Jitter]:
    """Return the pipe of a run with these numbers, and its jitter with what the pipe cannot hold.

    Numbers of the robot are not looked at: the profile has them already. Both coefficients of
    friction are scaled alike, on patches too; all diameters change alike.

    Raises:
        UsageError: A pipe has no such number, or it cannot be this.
    """
    given = {
        name.removeprefix(OF_PIPE): text
        for name, text in numbers.items()
        if name.startswith(OF_PIPE)
    }
    if wrong := unknown("a pipe has no number", given, PIPE_NUMBERS):
        raise UsageError(wrong)
    if not given:
        return pipe, Jitter(**jitter)
    own = numbers_of(pipe, profile)
    new = own | {name: _read(name, text) for name, text in given.items()}
    if abs(new["diameter"] - own["diameter"]) >= _MOST_OF_DIAMETER * own["diameter"]:
        raise UsageError(
            f"pipe.diameter: expected less than {_MOST_OF_DIAMETER:.0%} more or less than the "
            f"{own['diameter']:g} m of its file, got '{given['diameter']}'"
        )
    changed: dict[str, object] = {}
    if "tilt" in given and pipe.frame is not None:
        changed["frame"] = pipe.frame.model_copy(update={"pitch": new["tilt"]})
    elif "tilt" in given:
        changed["tilt"] = new["tilt"]
    if "roll" in given:
        changed["roll"] = new["roll"]
    if "friction" in given and not own["friction"]:
        raise UsageError("pipe.friction: the file has 0, which cannot be scaled")
    scale = new["friction"] / own["friction"] if "friction" in given else 1.0
    wider_m, forward_m = (new[name] - own[name] for name in ("diameter", "start"))
    differs = Jitter(**jitter, friction_scale=scale, wider_m=wider_m, forward_m=forward_m)
    return pipe.model_copy(update=changed), differs


def _read(name: str, text: str) -> float:
    dimension, least, most = PIPE_NUMBERS[name]
    try:
        value = read_quantity(text, dimension)
    except QuantityError as error:
        raise UsageError(f"{OF_PIPE}{name}: {error}") from None
    if not least <= value <= most:
        low, high = (format_quantity(each, dimension) for each in (least, most))
        raise UsageError(f"{OF_PIPE}{name}: expected from {low} to {high}, got '{text}'")
    return value
