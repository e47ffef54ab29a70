"""Decides by as few runs as possible whether a share of runs reaches a limit.

After each run, the number that passed is compared with two bounds. They spend the chances of error
of the whole test, run by run, by the exact binomial distribution: at a share below the limit,
``HOLDS`` is said with a chance of at most ``error``, however often one has looked, and at one above
it ``FAILS``. (Jennison and Turnbull, Group Sequential Methods with Applications to Clinical Trials,
2000, chapters 7 and 12.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log, sqrt
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pirate_sm.lab.campaign.intervals import Interval

Verdict: TypeAlias = Literal["holds", "fails", "doubtful", "refused"]
HOLDS: Verdict = "holds"
FAILS: Verdict = "fails"
DOUBTFUL: Verdict = "doubtful"
REFUSED: Verdict = "refused"
"""A run could not begin, so nothing is known of the share; a test itself never says this."""

MOST_RUNS = 1000
"""Of a level at most; the number of ways to more would not be a floating-point number."""

_STEPS = 50
"""Halvings of an interval whose end is searched: more would be below rounding."""


class _Bounds(NamedTuple):
    """After how many passes of so many runs a test ends.

    Attributes:
        holds: By the number of runs, as many passes or more.
        fails: As many or fewer.
        ends: Where a test can end: runs, passes, and the logarithm of in how many ways.
    """

    holds: tuple[float, ...]
    fails: tuple[float, ...]
    ends: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True)
class SequentialTest:
    """A test of whether a share of runs is at least a limit.

    Attributes:
        share: The limit.
        error: The chance of each of the two errors, at most.
        most: After so many runs the test ends, in doubt.
    """

    share: float
    error: float
    most: int

    @property
    def least(self) -> int:
        """How many runs ``most`` must be, so that the test can say both that it holds and fails.

        After the last run all of ``error`` is spent; all runs that passed, or none, are the
        clearest that there can be.
        """
        return ceil(log(self.error) / log(max(self.share, 1.0 - self.share)))

    def verdict(self, passed: int, runs: int) -> Verdict | None:
        """Return what is known after some runs; None if the next run is needed."""
        bounds = _bounds(self)
        if passed >= bounds.holds[runs]:
            return HOLDS
        if passed <= bounds.fails[runs]:
            return FAILS
        return DOUBTFUL if runs >= self.most else None

    def interval(self, passed: int, runs: int, confidence: float) -> Interval:
        """Return the interval of the share when the test has ended so.

        It has the shares at which neither so high nor so low an observed share would be a surprise.
        That counts how the test ends, which intervals for a fixed number of runs do not. The chance
        of what was observed itself counts half (mid-p), else intervals would be wider than needed.
        """
        tail = (1.0 - confidence) / 2
        return Interval(
            0.0 if passed == 0 else self._end(passed, runs, tail, above=True),
            1.0 if passed == runs else self._end(passed, runs, tail, above=False),
        )

    def _end(self, passed: int, runs: int, tail: float, *, above: bool) -> float:
        """Return the share at which the chance of so much, or so little, is ``tail``."""
        n, k, ways = _bounds(self).ends
        difference = k * runs - passed * n
        counts = np.where(difference == 0, 0.5, (difference > 0) == above)
        low, high = 0.0, 1.0
        for _ in range(_STEPS):
            share = (low + high) / 2
            chance = float(np.exp(ways + k * np.log(share) + (n - k) * np.log1p(-share)) @ counts)
            low, high = (share, high) if (chance < tail) == above else (low, share)
        return (low + high) / 2


@lru_cache(maxsize=16)
def _bounds(test: SequentialTest) -> _Bounds:
    """Return the bounds of a test, and where it can end."""
    holds, fails = [float("inf")], [-1.0]
    ways, ends = np.array([1.0]), list[tuple[int, int, float]]()
    spent_high = spent_low = 0.0
    for runs in range(1, test.most + 1):
        ways = np.append(ways, 0.0) + np.insert(ways, 0, 0.0)
        k = np.arange(runs + 1)
        chances = ways * test.share**k * (1.0 - test.share) ** (runs - k)
        budget = test.error * sqrt(runs / test.most)  # so that clear cases end early [decided]
        from_above = spent_high + np.cumsum(chances[::-1])
        from_below = spent_low + np.cumsum(chances)
        high, low = int(np.sum(from_above <= budget)), int(np.sum(from_below <= budget))
        holds.append(runs + 1 - high)
        fails.append(low - 1)
        spent_high = float(from_above[high - 1]) if high else spent_high
        spent_low = float(from_below[low - 1]) if low else spent_low
        ended = np.full(runs + 1, runs == test.most)
        ended[runs + 1 - high :] = ended[:low] = True
        ends += [(runs, int(at), float(ways[at])) for at in k[ended & (ways > 0.0)]]
        ways = np.where(ended, 0.0, ways)
    n, passed, counts = np.array(ends).T
    return _Bounds(tuple(holds), tuple(fails), (n, passed, np.log(counts)))
