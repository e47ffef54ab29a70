"""A value that was found in measurements, with its interval or the reason why it is unknown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isnan, nan

import numpy as np

from pirate_sm.simulation.arrays import Floats

_STRETCHES, _DRAWS = 20, 200
"""Numbers of stretches of a run and of draws for intervals: neighbours are alike."""


@dataclass(frozen=True)
class Estimate:
    """A value with its 95 % interval.

    Attributes:
        value: NaN where it is unknown.
        low: Lower end; where only a bound is known, that.
        high: Upper end.
        reason: Why it is unknown; empty where it is known.
    """

    value: float = nan
    low: float = nan
    high: float = nan
    reason: str = ""

    @property
    def known(self) -> bool:
        """Whether there is a value."""
        return not isnan(self.value)


def estimate_of(rows: Floats, statistic: Callable[[Floats], float], shortest: int = 1) -> Estimate:
    """Return a statistic with its interval, from draws of whole stretches of the run.

    Args:
        rows: What was measured, in the order of time.
        statistic: Returns the value that some of it gives; NaN if none.
        shortest: How many rows a stretch has at least.
    """
    random = np.random.default_rng(0)
    stretches = np.array_split(rows, min(_STRETCHES, len(rows) // shortest))
    drawn = [
        statistic(np.concatenate([stretches[i] for i in picked]))
        for picked in random.integers(len(stretches), size=(_DRAWS, len(stretches)))
    ]
    low, high = np.nanquantile(drawn, [0.025, 0.975])
    return Estimate(statistic(rows), float(low), float(high))
