"""Writes what a recording says of a robot as a twin: one robot, and a sample of possible ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from math import isnan
from typing import NamedTuple

import numpy as np

from pirate_sm.core.models import Profile
from pirate_sm.lab.fitting.measurements import DRAWS, Estimate
from pirate_sm.lab.fitting.robot_numbers import ROLLING, RobotNumber
from pirate_sm.simulation.arrays import Floats

# --- a sample of robots --------------------------------------------------------------------------


ROBOTS = 64
"""Robots of a sample."""

_ASSUMED_WITHIN = 4.0
"""A number that no recording shows lies within this factor of what the profile says [assumed; the
four joints of the thesis bore 0.159 to 1.92 Nm where 1.01 were expected]."""

_MOST_FRICTION = 5.0
"""A file takes no more."""


_ROLLING, _MOST_ROLLING = "tyre rolling_resistance", 0.2
"""Its column in a sample, and the most that a file accepts."""


class LikelyRobots(NamedTuple):
    """Equally likely robots: the names of their numbers, the assumed ones, a row for each robot."""

    numbers: tuple[str, ...]
    assumed: tuple[str, ...]
    robots: tuple[tuple[float, ...], ...]


def sample_of(profile: Profile, numbers: Sequence[RobotNumber], robots: int) -> LikelyRobots | None:
    """Return robots as likely as each other, at most ``DRAWS``; None where none is possible.

    A number that is neither known nor assumed, as one of 0, is left to the profile.
    Numbers that are known come from the same draw of stretches of the recording, which keeps how
    they depend on each other. The others are drawn from what is assumed.
    """
    random = np.random.default_rng(0)
    columns: dict[str, Floats] = {}
    assumed: list[str] = []
    for each in numbers:
        if not each.motor:
            continue
        name, draws = f"{each.motor} {each.key}", each.estimate.likely
        places = random.uniform(size=DRAWS)  # of known numbers too, so that others stay the same
        if not each.estimate.known:
            value = getattr(profile.motors[each.motor], each.key)
            if not value:
                continue
            assumed.append(name)
            draws = _assumed(places, value, each.estimate.low)
        columns[name] = draws
    places, surplus = random.uniform(size=(2, DRAWS))
    friction = profile.simulation.friction
    parts = [each.estimate.likely for each in numbers if each.is_friction and each.estimate.known]
    if parts or friction.kinetic:
        if not parts:
            assumed.append("friction kinetic")
        assumed.append("friction static")
        kinetic = np.mean(parts, axis=0) if parts else _assumed(places, friction.kinetic, np.nan)
        kinetic = np.minimum(kinetic, _MOST_FRICTION)
        static = kinetic * (1 + (_static_share(profile) - 1) * 2 * surplus)
        columns["friction kinetic"] = kinetic
        columns["friction static"] = np.minimum(static, _MOST_FRICTION)
    if rolling := _rolling(numbers):
        columns[_ROLLING] = np.minimum(rolling.likely, _MOST_ROLLING)
    if not columns:
        return None
    rows = np.column_stack(list(columns.values()))
    rows = rows[np.isfinite(rows).all(axis=1) & (rows > 0).all(axis=1)][:robots]
    if not len(rows):
        return None
    return LikelyRobots(tuple(columns), tuple(assumed), tuple(map(tuple, rows.tolist())))


def _rolling(numbers: Iterable[RobotNumber]) -> Estimate | None:
    """Return the rolling resistance, if it is known."""
    found = (each.estimate for each in numbers if each.key == ROLLING and each.estimate.known)
    return next(found, None)


def _static_share(profile: Profile) -> float:
    """Return how many times as large as kinetic friction static is; once where both are 0."""
    friction = profile.simulation.friction
    return friction.static / friction.kinetic if friction.kinetic else 1.0


def _assumed(places: Floats, value: float, least: float) -> Floats:
    """Return draws around a value of the profile, none below what the recording has shown."""
    low = value / _ASSUMED_WITHIN if isnan(least) else max(value / _ASSUMED_WITHIN, least)
    high = max(value, low) * _ASSUMED_WITHIN
    draws: Floats = low * (high / low) ** places
    return draws


# --- as a file -----------------------------------------------------------------------------------


def twin_text(
    profile: Profile, numbers: Iterable[RobotNumber], source: str, robots: int = ROBOTS
) -> str:
    """Return the file: what is known, as comments what is not, and the sample.

    Args:
        profile: Of the robot.
        numbers: What was estimated.
        source: What it was estimated from, for people.
        robots: How many the sample has.
    """
    lines = [
        f"# Numbers of one robot, estimated from {source} by `pirate fit --robot`.",
        "# The simulator takes them instead of the profile's: pirate-run MISSION --twin FILE",
        "format: 1",
        f"robot: {profile.robot}",
    ]
    numbers = list(numbers)
    known = [each for each in numbers if each.motor and each.estimate.known]
    if known:
        lines.append("motors:")
    for motor in dict.fromkeys(each.motor for each in known):
        lines.append(f"  {motor}:")
        for each in known:
            if each.motor == motor:
                low, high = each.estimate.low, each.estimate.high
                value = f"    {each.key}: {each.estimate.value:.4g} {each.unit}"
                lines.append(f"{value}    # 95 %: {low:.4g} to {high:.4g}")
    for each in numbers:
        if not each.estimate.known:
            what = f"{each.motor} {each.key}".strip()
            lines.append(f"# unknown: {what}: {each.estimate.reason}")
        elif not each.motor:
            lines.append(f"# {each.key}: {each.estimate.value:.3f}")
    kinetic = [each.estimate.value for each in numbers if each.is_friction and each.estimate.known]
    if kinetic:
        mean = sum(kinetic) / len(kinetic)
        static = min(mean * _static_share(profile), _MOST_FRICTION)
        lines.append("# The simulator has one friction: the mean, static in the profile's ratio.")
        lines.append(f"friction: {{static: {static:.3f}, kinetic: {mean:.3f}}}")
    if rolling := _rolling(numbers):
        most = min(rolling.value, _MOST_ROLLING)
        lines.append(f"tyre: {{rolling_resistance: {most:.4f}}}")
    sample = sample_of(profile, numbers, robots)
    return "\n".join([*lines, *(() if sample is None else _sample_lines(sample)), ""])


def _sample_lines(sample: LikelyRobots) -> Iterator[str]:
    """Yield the lines of a sample, with a robot in each."""
    yield "# Robots that the recording leaves possible, in SI units: --twin FILE#0 and so on."
    yield "sample:"
    yield f"  numbers: [{', '.join(sample.numbers)}]"
    yield f"  assumed: [{', '.join(sample.assumed)}]"
    yield "  robots:"
    for row in sample.robots:
        yield f"    - [{', '.join(f'{value:.4g}' for value in row)}]"
