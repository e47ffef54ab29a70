"""The curves of a report's plots in its phases, and the bands of earlier runs behind them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isnan, nan

import numpy as np

from pirate_sm.running.recording.signal_bands import (
    CurveName,
    PhaseBands,
    PhaseExtremes,
    RunExtremes,
    edges_of,
    extremes_of,
    intervals_of,
    step_of,
)
from pirate_sm.running.runtime.phase_times import PhaseKey, PhaseStay
from pirate_sm.views.report.contents import Chart, CurveBand, Report


def run_extremes(report: Report) -> RunExtremes:
    """Return between which values each curve of the plots ran, for the bands of later runs."""
    curves = [
        (chart, series, np.array(series.times_s), np.array(series.values, np.float64))
        for chart in report.charts
        for series in chart.series
    ]
    found = dict[PhaseKey, PhaseExtremes]()
    for key, since_s, until_s in report.passages:
        if until_s <= since_s:
            continue
        step_s = step_of(until_s - since_s)
        edges_s = edges_of(since_s, until_s, step_s)
        found[key] = PhaseExtremes(
            until_s - since_s,
            step_s,
            {
                CurveName(chart.title, series.name): extremes_of(
                    times_s, values, edges_s, chart.digits, stepped=series.stepped
                )
                for chart, series, times_s, values in curves
            },
        )
    return found


def with_bands(
    charts: Sequence[Chart],
    passages: Sequence[PhaseStay],
    phases: Sequence[PhaseBands],
    words: str,
) -> tuple[Chart, ...]:
    """Return the plots with bands behind those curves that have one.

    Args:
        charts: The plots.
        passages: The phases of the run.
        phases: The bands of earlier runs.
        words: What they are, in words.
    """
    known = {
        each.key: (each.step_s, {CurveName(*name): text for *name, text in each.curves})
        for each in phases
    }
    entered = [(each, *known[each.key]) for each in passages if each.key in known]
    found = []
    for chart in charts:
        series = tuple(
            replace(each, band=_band(CurveName(chart.title, each.name), entered))
            for each in chart.series
        )
        banded = any(each.band is not None for each in series)
        found.append(replace(chart, series=series, bands=words) if banded else chart)
    return tuple(found)


def _band(
    name: CurveName, entered: Sequence[tuple[PhaseStay, float, Mapping[CurveName, str]]]
) -> CurveBand | None:
    """Return the band of a curve in all phases of the run; None if it has none."""
    band = CurveBand([], [], [])
    for (_, since_s, until_s), step_s, texts in entered:
        edges_s = edges_of(since_s, until_s, step_s).tolist()
        bounds = intervals_of(texts[name]) if name in texts else []
        bounds += [(nan, nan)] * (len(edges_s) - len(bounds))
        bounds[len(edges_s) - 1 :] = [(nan, nan)]  # from the end of the phase on
        band.times_s.extend(edges_s)
        band.low.extend(low for low, _ in bounds)
        band.high.extend(high for _, high in bounds)
    return None if all(map(isnan, band.low)) else band
