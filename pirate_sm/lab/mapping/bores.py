"""Changes of the inner diameter along a leg, from what the Vs of clamped parts showed."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import pairwise
from statistics import median
from typing import NamedTuple

from pirate_sm.lab.mapping.legs import Bore

_BIN_M = 0.01
"""Diameters are averaged over this distance [decided]."""

_STRETCH_BINS = 4
"""This number of consecutive averages makes a stretch of one diameter [decided]."""

_PLATEAU_BINS = 7
"""A plain pipe shows its diameter over this distance: half a V is shorter, and while a step is
between two of its wheels a V shows a wrong diameter [decided]."""

_EVEN = 0.01
"""They differ by less than this share [decided]."""

STEP = 0.06
"""The least share by which diameters of plain pipes differ. A robot that lies slantwise in a round
pipe shows up to 5 % less; pipes of 125, 110 and 100 mm differ by 9 % and more [decided]."""


class Narrowing(NamedTuple):
    """A change of the diameter.

    Attributes:
        middle_m: Place in the leg of its middle; a V does not show how long it is.
        diameter_m: The inner diameter behind it.
    """

    middle_m: float
    diameter_m: float


def diameter_of(bores: Sequence[Bore]) -> float | None:
    """Return the first inner diameter along a leg, m; None if it was never shown."""
    plateaus = _plateaus(bores)
    if plateaus:
        return median(each.diameter_m for each in plateaus[0])
    return median(each.diameter_m for each in bores) if bores else None


def narrowings(bores: Sequence[Bore]) -> Iterator[Narrowing]:
    """Yield the changes of the diameter along a leg, in order.

    A V in the middle of a change shows the mean of the two diameters.
    """
    bins = list(_bins(bores))
    for before, after in pairwise(_plateaus(bores)):
        old_m, new_m = (median(each.diameter_m for each in it) for it in (before, after))
        between = bins[bins.index(before[0]) : bins.index(after[-1]) + 1]
        for one, other in pairwise(between):
            shares = [(it.diameter_m - old_m) / (new_m - old_m) for it in (one, other)]
            if shares[0] < 0.5 <= shares[1]:
                more = (0.5 - shares[0]) / (shares[1] - shares[0])
                yield Narrowing(one.middle_m + more * (other.middle_m - one.middle_m), new_m)
                break


def _plateaus(bores: Sequence[Bore]) -> list[list[Bore]]:
    """Return the stretches of one diameter, in order; neighbours differ by more than noise."""
    found: list[list[Bore]] = []
    part: list[Bore] = []
    for each in (*_bins(bores), None):
        known = median([it.diameter_m for it in part]) if part else 0.0
        if each is not None and abs(each.diameter_m - known) <= _EVEN * known:
            part.append(each)
            continue
        if len(part) >= _STRETCH_BINS:
            _add(found, part)
        part = [each] if each is not None else []
    return [stretch for stretch in found if len(stretch) >= _PLATEAU_BINS]


def _add(found: list[list[Bore]], part: list[Bore]) -> None:
    """Add a stretch, or join it to the last one if it has the same diameter."""
    own = median(each.diameter_m for each in part)
    last = median(each.diameter_m for each in found[-1]) if found else 0.0
    if found and abs(own - last) <= STEP * last:
        found[-1] += part
    else:
        found.append(part)


def _bins(bores: Sequence[Bore]) -> Iterator[Bore]:
    """Yield what was shown in each piece of the way."""
    pieces: dict[int, list[Bore]] = defaultdict(list)
    for each in bores:
        pieces[round((each.rear_m + each.front_m) / 2 / _BIN_M)].append(each)
    for _, group in sorted(pieces.items()):
        yield Bore(*(median(values) for values in zip(*group, strict=True)))
