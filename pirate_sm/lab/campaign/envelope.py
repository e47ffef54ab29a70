"""Finds how far round its nominal value a factor may be changed; says which values to try next.

Each side is looked at by itself. First, some values at equal distances are tried. Then the distance
between the last value that holds, counted from the nominal one, and the next is halved a few times.
All this is a function of the verdicts so far: a search that was interrupted simply continues.

*What is known then.* Each verdict may be wrong with a chance of ``error``. A side is wrong if a
value beyond its true edge was said to hold. On the way out only the first value beyond it can do
that, as the search goes no farther than to one that does not hold; afterwards each halving can.
So with ``error`` = (1 - confidence) / (1 + halvings) the edge of a side is too far out with a
chance of at most 1 - confidence. This assumes that between two neighbouring values that hold
nothing fails, and that success does not come back behind the edge. Values behind it that hold are
reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple, TypeAlias

from pirate_sm.lab.campaign.margins_model import MarginFactor
from pirate_sm.lab.campaign.sequential import FAILS, HOLDS, Verdict

VerdictAt: TypeAlias = Callable[[Mapping[MarginFactor, float]], Verdict | None]
"""Returns the verdict of the runs with factors at some values; None if it is not known yet."""

MAP = 7
"""Values of each factor in the map of a pair: 49 fields can still be read [decided]."""


class Side(NamedTuple):
    """How far a factor may be changed to one side.

    Attributes:
        tried: The values that were tried, from the nominal one outward, with what is known of them.
        wanted: The values to try next; empty if all is known.
        edge: The last value that holds with all between it and the nominal one.
        fails: The first value behind it that fails; None: none that was tried does.
        again: Values behind the edge that hold.
    """

    tried: tuple[tuple[float, Verdict | None], ...]
    wanted: tuple[float, ...]
    edge: float
    fails: float | None
    again: tuple[float, ...]

    @property
    def whole(self) -> bool:
        """Whether everything that was tried holds."""
        return all(verdict == HOLDS for _, verdict in self.tried)


def look(
    factor: MarginFactor,
    end: float,
    verdict_at: Callable[[float], Verdict | None],
    levels: int,
    halvings: int,
    also: Sequence[float] = (),
) -> Side:
    """Return what is known of one side of a factor, round a cell that holds.

    The nominal value of a defect that is added is tried like the others.

    Args:
        factor: The factor.
        end: The end of its range on this side.
        verdict_at: Returns what is known of a value.
        levels: Values at equal distances that are tried first.
        halvings: How often the distance behind the last one that holds is halved.
        also: Further values that are tried, between the nominal value and the end.
    """
    nominal = factor.nominal
    if end == nominal:
        return Side((), (), nominal, None, ())
    first = 0 if factor.added else 1
    scan = {nominal + (end - nominal) * n / levels for n in range(first, levels + 1)} | {*also}
    outward = sorted({factor.rounded(each) for each in scan}, key=lambda x: abs(x - nominal))
    tried = {each: verdict_at(each) for each in outward if factor.added or each != nominal}
    wanted = [each for each, verdict in tried.items() if verdict is None]
    edge, beyond = _edge(nominal, tried)
    for _ in range(halvings if beyond is not None else 0):
        if beyond is None or tried[beyond] is None:
            break
        middle = factor.rounded((edge + beyond) / 2)
        if middle in (edge, beyond):
            break
        tried[middle] = verdict_at(middle)
        if tried[middle] is None:
            wanted.append(middle)
            break
        edge, beyond = _edge(nominal, tried)
    found = sorted(tried.items(), key=lambda each: abs(each[0] - nominal))
    behind = [each for each in found if abs(each[0] - nominal) > abs(edge - nominal)]
    fails = next((value for value, verdict in behind if verdict == FAILS), None)
    again = tuple(value for value, verdict in behind if verdict == HOLDS)
    return Side(tuple(found), tuple(wanted), edge, fails, again)


def _edge(nominal: float, tried: Mapping[float, Verdict | None]) -> tuple[float, float | None]:
    """Return the last value that holds with all before it, and the next one."""
    edge = nominal
    for value in sorted(tried, key=lambda x: abs(x - nominal)):
        if tried[value] != HOLDS:
            return edge, value
        edge = value
    return edge, None


@dataclass(frozen=True)
class Envelope:
    """How far one factor may be changed.

    Attributes:
        factor: The factor.
        below: The side below the nominal value; likewise ``above``.
    """

    factor: MarginFactor
    below: Side
    above: Side

    @property
    def wanted(self) -> tuple[float, ...]:
        """The values to try next."""
        return self.below.wanted + self.above.wanted


def envelope(
    factor: MarginFactor,
    verdict_at: VerdictAt,
    levels: int,
    halvings: int,
    also: Sequence[float] = (),
) -> Envelope:
    """Return what is known of both sides of a factor; see :func:`look`."""
    one_sided = factor.nominal in (factor.low, factor.high)

    def side(end: float) -> Side:
        mine = [each for each in also if (each < factor.nominal) == (end < factor.nominal)]
        count = 2 * levels if one_sided else levels
        return look(factor, end, lambda at: verdict_at({factor: at}), count, halvings, mine)

    return Envelope(factor, side(factor.low), side(factor.high))


def grid(pair: tuple[MarginFactor, MarginFactor]) -> Iterator[dict[MarginFactor, float]]:
    """Yield the places of the map of a pair: the first factor across, the second one up."""
    across, up = (
        [each.low + (each.high - each.low) * n / (MAP - 1) for n in range(MAP)] for each in pair
    )
    for second, first in product(up, across):
        yield {pair[0]: pair[0].rounded(first), pair[1]: pair[1].rounded(second)}
