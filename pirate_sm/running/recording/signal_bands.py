"""How curves ran in the phases of earlier runs, as bands that are bounded by the runs' order.

Time is divided from the beginning of a phase. In each interval a run counts with the least and the
largest value of its curve, and the band reaches from the k-th smallest least to the k-th largest of
the largest values. The next run passes either bound with probability k / (n + 1), so that all of
its curve in that interval is inside with at least (n + 1 - 2 k) / (n + 1), as with times
(:mod:`pirate_sm.running.runtime.phase_times`). This holds for each interval by itself.

A run that has left the phase before an interval does not count in it. So a run that is in the phase
for as long is compared with those that were, and with them alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import ceil
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from pydantic import Field, StringConstraints

from pirate_sm.core.fields import Frozen
from pirate_sm.running.runtime.phase_times import (
    LEAST_RUNS,
    WORTH_SAYING_S,
    PhaseKey,
    rank_of_bounds,
)

Floats: TypeAlias = npt.NDArray[np.float64]

MOST_RUNS = 199
"""More runs are left out: ten are outside on each side already, and each has to be replayed."""

_MOST_INTERVALS = 40
"""A phase has 20 to 40 intervals, except a short one: a plot shows no more [decided]."""

_FINEST_S = 0.25
"""Shorter intervals than this, doubled as often as needed, are not distinguished [decided]."""

_LONGEST_TEXT = 400_000
"""Larger bands get longer intervals: the file may have a megabyte, and has the times too."""

# --- of one run -----------------------------------------------------------------------------------


class CurveName(NamedTuple):
    """A curve by the title of its plot and its own name."""

    plot: str
    name: str


class Extremes(NamedTuple):
    """The least and the largest value of a curve in each interval; NaN where it is unknown."""

    least: Floats
    largest: Floats

    def coarser(self, factor: int) -> Extremes:
        """Return those of intervals that are so many times as long."""
        begins = np.arange(0, len(self.least), factor)
        return Extremes(
            np.fmin.reduceat(self.least, begins), np.fmax.reduceat(self.largest, begins)
        )


class PhaseExtremes(NamedTuple):
    """The curves of a run in one of its phases.

    Attributes:
        step_s: The length of an interval; the last one may be shorter.
    """

    took_s: float
    step_s: float
    curves: Mapping[CurveName, Extremes]


RunExtremes: TypeAlias = Mapping[PhaseKey, PhaseExtremes]


def step_of(took_s: float) -> float:
    """Return the length of the intervals of a phase that took so long, s."""
    step_s = _FINEST_S
    while took_s > _MOST_INTERVALS * step_s:
        step_s *= 2
    return step_s


def extremes_of(
    times_s: Floats, values: Floats, edges_s: Floats, digits: int, *, stepped: bool
) -> Extremes:
    """Return the extremes of a curve between edges, rounded outwards.

    Args:
        times_s: Its times; a line leads from point to point.
        values: Its values, NaN where it is unknown.
        edges_s: Where intervals begin, and where the last one ends.
        digits: Decimals of the result.
        stepped: Whether a value holds until the next one instead.
    """
    between = slice(*np.searchsorted(times_s, (edges_s[0], edges_s[-1])).tolist())
    there = _at(times_s, values, edges_s, stepped=stepped)
    order = np.argsort(np.concatenate((edges_s, times_s[between])), kind="stable")
    all_values = np.concatenate((there, values[between]))[order]
    begins = np.flatnonzero(order < len(edges_s))
    least, largest = (of.reduceat(all_values, begins)[:-1] for of in (np.fmin, np.fmax))
    if not stepped:  # the line leads to the end of the interval
        least, largest = np.fmin(least, there[1:]), np.fmax(largest, there[1:])
    scale = 10.0**digits
    return Extremes(np.floor(least * scale) / scale, np.ceil(largest * scale) / scale)


def _at(times_s: Floats, values: Floats, at_s: Floats, *, stepped: bool) -> Floats:
    """Return the values at times; after the last point and before a gap the value holds."""
    padded = np.concatenate(([np.nan], values, [np.nan]))
    before = np.searchsorted(times_s, at_s, "right")
    one, other = padded[before], padded[before + 1]
    if stepped or not len(times_s):
        return one
    known = np.concatenate(([0.0], times_s, [times_s[-1] + 1.0]))
    share = (at_s - known[before]) / (known[before + 1] - known[before])
    return np.where(np.isnan(other), one, one + (other - one) * share)


# --- of many runs ---------------------------------------------------------------------------------

_BOUNDS = r"-?\d+(\.\d+)?(e[+-]\d+)?"
_ENTRY = rf"(({_BOUNDS})\.\.({_BOUNDS})|-)(\*\d{{1,2}})?"

BandText: TypeAlias = Annotated[
    str, StringConstraints(pattern=rf"^{_ENTRY}( {_ENTRY})*$", max_length=4_000)
]
"""The band of a curve: of each interval its bounds, as ``-2.5..3``, or ``-`` where too few runs are
known; ``*7`` after them is for seven intervals in succession."""


class PhaseBands(Frozen):
    """The bands of the curves in a phase.

    Attributes:
        phase: The phase.
        time: How many times the run has entered it.
        step_s: The length of an interval.
        curves: The title of a plot, the name of a curve, and its band.
    """

    phase: str
    time: Annotated[int, Field(ge=1)]
    step_s: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    curves: tuple[tuple[str, str, BandText], ...]

    @property
    def key(self) -> PhaseKey:
        """Return the phase with the number of its entry."""
        return PhaseKey(self.phase, self.time)


class SignalBands(Frozen):
    """The bands of curves, of all phases that have any.

    Attributes:
        runs: How many runs they are made of.
    """

    runs: Annotated[int, Field(ge=1)]
    phases: tuple[PhaseBands, ...]


def signal_bands(runs: Sequence[RunExtremes]) -> SignalBands | None:
    """Return the bands of the next run after these; None without any, or with too many phases."""
    entered: dict[PhaseKey, list[PhaseExtremes]] = {}
    for run in runs:
        for key, each in run.items():
            entered.setdefault(key, []).append(each)
    kept = {
        key: each
        for key, each in entered.items()
        if len(each) >= LEAST_RUNS and max(it.took_s for it in each) >= WORTH_SAYING_S
    }
    factor = 1
    while factor <= _MOST_INTERVALS:
        bands = [found for key, each in kept.items() if (found := _of_phase(key, each, factor))]
        if sum(len("".join(curve)) for each in bands for curve in each.curves) <= _LONGEST_TEXT:
            return SignalBands(runs=len(runs), phases=tuple(bands)) if bands else None
        factor *= 2
    return None


def _of_phase(key: PhaseKey, runs: Sequence[PhaseExtremes], factor: int) -> PhaseBands | None:
    step_s = factor * max(each.step_s for each in runs)
    curves: dict[CurveName, list[Extremes]] = {}
    for each in runs:
        for name, extremes in each.curves.items():
            coarser = extremes.coarser(round(step_s / each.step_s))
            curves.setdefault(name, []).append(coarser)
    texts = ((*name, _text(band_of_curves(each))) for name, each in curves.items())
    kept = tuple(each for each in texts if each[-1])
    return PhaseBands(phase=key.phase, time=key.nth, step_s=step_s, curves=kept) if kept else None


def band_of_curves(runs: Iterable[Extremes]) -> Extremes:
    """Return the band of a curve after those of earlier runs; NaN where too few are known."""
    given = tuple(runs)
    least, largest = np.full((2, len(given), max(len(each.least) for each in given)), np.nan)
    for row, each in enumerate(given):
        least[row, : len(each.least)], largest[row, : len(each.largest)] = each
    counts = np.count_nonzero(~np.isnan(least), axis=0)
    ranks = np.array([rank_of_bounds(count) for count in counts.tolist()])
    low, high = (
        np.take_along_axis(np.sort(each, axis=0), np.maximum(ranks - 1, 0)[None], 0)[0]
        for each in (least, -largest)
    )
    return Extremes(np.where(ranks, low, np.nan), np.where(ranks, -high, np.nan))


def _text(band: Extremes) -> BandText:
    """Return the band as text, without what is unknown at its end; empty if nothing is known."""
    entries = [
        "-" if np.isnan(low) else f"{low + 0.0:.9g}..{high + 0.0:.9g}"
        for low, high in zip(*band, strict=True)
    ]
    while entries and entries[-1] == "-":
        entries.pop()
    found = list[str]()
    count = 0
    for place, entry in enumerate(entries):
        count += 1
        if entries[place + 1 : place + 2] != [entry]:
            found.append(entry if count == 1 else f"{entry}*{count}")
            count = 0
    return " ".join(found)


def intervals_of(text: BandText) -> list[tuple[float, float]]:
    """Return the bounds of each interval of a band; NaN where too few runs were known."""
    found = list[tuple[float, float]]()
    for entry in text.split(" "):
        bounds, _, count = entry.partition("*")
        low, _, high = bounds.partition("..") if bounds != "-" else ("nan", "", "nan")
        found += [(float(low), float(high))] * int(count or 1)
    return found


def edges_of(since_s: float, until_s: float, step_s: float) -> Floats:
    """Return where the intervals of a phase begin, and where its last one ends, s."""
    intervals = max(1, ceil(round((until_s - since_s) / step_s, 6)))
    edges_s: Floats = since_s + step_s * np.arange(intervals + 1, dtype=np.float64)
    edges_s[-1] = until_s
    return edges_s
