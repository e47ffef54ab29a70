"""Our distribution of slip ratios next to that of the thesis, as far as it is printed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pirate_sm.lab.experiments.thesis_rows import ThesisRow
from pirate_sm.simulation.arrays import Floats
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries

_BINS = 60
_WIDE = 0.5
"""Ratios up to here are drawn; in driving the thesis has 0.3 (section 6-2)."""


def slip_histogram(rows: Iterable[ThesisRow], name: str, wheel: str, ratio: Floats) -> Plot:
    """Return the histogram of a wheel's ratios in driving, and the thesis's mean with its spread.

    Args:
        rows: Of the thesis; the band of a mean is its mean plus and minus a standard deviation.
        name: Of the run, such as 1a.
        wheel: Name of the wheel.
        ratio: Its slip ratios in driving.
    """
    counts, edges = np.histogram(ratio, bins=_BINS, range=(-_WIDE, _WIDE))
    density = counts / (max(int(counts.sum()), 1) * (edges[1] - edges[0]))
    middles = (edges[1:] + edges[:-1]) / 2
    row = next((each for each in rows if each.ours == f"{name}.{wheel}.driving_mean"), None)
    series = [PlotSeries(f"ours, n = {len(ratio)}", middles.tolist(), density.tolist())]
    if row is not None and row.between is not None:
        low, high = row.between
        off = (middles - (low + high) / 2) / ((high - low) / 2)
        printed = np.exp(-0.5 * off**2) / (np.sqrt(np.pi / 2) * (high - low))
        base = np.zeros_like(printed).tolist()
        text = "thesis, mean and std. of table 6-1, its n is not printed"
        series.append(PlotSeries(text, middles.tolist(), base, "band", printed.tolist(), colour=1))
    title = f"Table 6-1, {name}: slip ratio of {wheel} in driving"
    return Plot(title, "slip ratio", "density", tuple(series))
