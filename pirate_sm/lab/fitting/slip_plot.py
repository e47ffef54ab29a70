"""The plot of slip and friction with both fitted curves, as in figures 6-8 and 6-12c."""

from __future__ import annotations

import numpy as np

from pirate_sm.lab.fitting.slip_curve import SlipCurve
from pirate_sm.views.drawing.svg.plot import Plot, PlotSeries

_SURE = 1.96
_PLACES = 300


def slip_plot(curve: SlipCurve, title: str) -> Plot:
    """Return medians of the points, the Magic formula, and the Gaussian process with its band."""
    slip, friction = curve.bins
    series = [PlotSeries("medians of the points", slip.tolist(), friction.tolist(), "dots")]
    if curve.magic is not None and curve.process is not None:
        x = np.geomspace(slip.min(), slip.max(), _PLACES)
        mean, deviation = curve.process(np.log10(x))
        low, high = mean - _SURE * deviation, mean + _SURE * deviation
        series = [
            PlotSeries("", x.tolist(), low.tolist(), "band", high.tolist(), colour=2),
            *series,
            PlotSeries("Gaussian process, 95 %", x.tolist(), mean.tolist(), colour=2),
            PlotSeries("Magic formula", x.tolist(), curve.magic(x).tolist(), colour=1),
        ]
    return Plot(title, "slip speed, m/s", "friction in use |F| / N", tuple(series), log_x=True)
