"""How sure a share of runs is, and whether two shares differ."""

from __future__ import annotations

from math import exp, lgamma, log, sqrt
from statistics import NormalDist
from typing import NamedTuple


class Interval(NamedTuple):
    """An interval of a share, from 0 to 1."""

    least: float
    most: float

    @property
    def half_width(self) -> float:
        """Half its width."""
        return (self.most - self.least) / 2


def wilson(successes: int, runs: int, confidence: float) -> Interval:
    """Return Wilson's score interval of a share.

    Wilson, "Probable inference, the law of succession, and statistical inference", Journal of the
    American Statistical Association 22 (1927) 209-212.

    Args:
        successes: How many of the runs succeeded.
        runs: How many runs there were; without any, nothing is known.
        confidence: Such as 0.95.
    """
    if runs == 0:
        return Interval(0.0, 1.0)
    z = NormalDist().inv_cdf((1.0 + confidence) / 2)
    share, scale = successes / runs, 1.0 + z * z / runs
    middle = (share + z * z / (2 * runs)) / scale
    half = z / scale * sqrt(share * (1.0 - share) / runs + z * z / (4 * runs * runs))
    least = 0.0 if successes == 0 else middle - half
    return Interval(least, 1.0 if successes == runs else middle + half)


_SAME = 1.0 + 1e-7
"""Tables whose chances differ by less count as equally likely; logarithms are not exact."""


def fisher_exact(successes: int, runs: int, other_successes: int, other_runs: int) -> float:
    """Return how likely two shares differ so much by chance: Fisher's exact test, two-sided.

    With the margins of the 2 × 2 table fixed, the first success count is hypergeometric. The
    chances of all tables that are at most as likely as this one are added.

    Args:
        successes: Of the first.
        runs: Of the first.
        other_successes: Of the second.
        other_runs: Of the second.
    """
    total, all_runs = successes + other_successes, runs + other_runs
    ways = _log_choose(all_runs, total)

    def chance(first: int) -> float:
        return exp(_log_choose(runs, first) + _log_choose(other_runs, total - first) - ways)

    limit = chance(successes) * _SAME
    possible = range(max(0, total - other_runs), min(runs, total) + 1)
    return min(1.0, sum(p for p in map(chance, possible) if p <= limit))


def mcnemar_exact(lost: int, gained: int) -> float:
    """Return how likely pairs of runs change so one-sidedly by chance: McNemar's test, two-sided.

    Pairs whose runs end alike say nothing; of the others, each is as likely lost as gained. The
    exact test adds the binomial chances, which the normal approximation misses for few pairs.

    Args:
        lost: Pairs of which the first passed and the second did not.
        gained: Pairs of which the second passed and the first did not.
    """
    changed = lost + gained
    ways = changed * log(2.0)
    tail = sum(exp(_log_choose(changed, n) - ways) for n in range(min(lost, gained) + 1))
    return min(1.0, 2.0 * tail)


def _log_choose(n: int, k: int) -> float:
    return lgamma(n + 1) - lgamma(k + 1) - lgamma(n - k + 1)
