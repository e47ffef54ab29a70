"""What each run of a cell draws from its seed: start, friction, diameter, numbers of defects."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pirate_sm.core.options import JITTER
from pirate_sm.core.profile import Profile
from pirate_sm.core.units import DIMENSIONLESS, LENGTH, parse_quantity, unit_of
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.defects import drawn
from pirate_sm.simulation.surroundings import Jitter, drawn_jitter

FROM_FILES = tuple(f"{each.key}_m" if each.unit == LENGTH else each.key for each in JITTER)
"""The factors that are how far a run differs from its files."""


class Factor(NamedTuple):
    """A number that each run of a cell draws uniformly.

    Attributes:
        name: One of ``FROM_FILES``, or the number of a defect: its name, ``_`` and the key.
        unit: The SI unit; empty for a share.
        low: Its least value; likewise ``high``.
    """

    name: str
    unit: str
    low: float
    high: float


def factors_of(order: Order) -> tuple[Factor, ...]:
    """Return what the runs of an order draw."""
    found = [
        Factor(name, unit_of(each.unit or DIMENSIONLESS), -most, most)
        for name, each in zip(FROM_FILES, JITTER, strict=True)
        if (most := getattr(order, each.name))
    ]
    for name, written in _numbers(order.defects):
        low, dots, high = map(str.strip, written.partition(".."))
        if dots and low != high:
            least, most = parse_quantity(low), parse_quantity(high).value
            found.append(Factor(name, unit_of(least.dimension), least.value, most))
    return tuple(found)


def drawn_factors(order: Order, profile: Profile) -> Mapping[str, float]:
    """Return what the run of an order, with its seed, draws: each factor in SI units.

    Raises:
        UsageError: The robot does not have the defects.
    """
    differs = drawn_jitter(Jitter(**order.jitter), np.random.default_rng(order.seed))
    numbers = dict(_numbers(drawn(order.defects, profile, order.seed)))
    values = {name: parse_quantity(text).value for name, text in numbers.items()}
    values |= zip(FROM_FILES, (differs.start_m, differs.friction, differs.diameter_m), strict=True)
    return {each.name: values[each.name] for each in factors_of(order)}


def _numbers(defects: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield each number in the texts of defects, as it is written, by a name of its own."""
    for text in defects:
        defect, _, rest = text.partition(":")
        for pair in filter(None, rest.split(",")):
            key, _, written = pair.partition("=")
            yield f"{defect}_{key.strip()}", written.strip()
